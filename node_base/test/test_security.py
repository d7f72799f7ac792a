"""DDS security that is asked for but cannot be had: nothing runs unprotected."""

import subprocess
import sys

from loop_processes import PROGRAM

KEYS = (
    *("identity_ca.cert.pem", "permissions_ca.cert.pem", "cert.pem", "key.pem"),
    *("governance.p7s", "permissions.p7s"),
)


def test_with_security_enforced_a_node_without_valid_keys_ends_in_one_line(loop, tmp_path):
    enclave = tmp_path / "keys" / "enclaves" / "heave"
    enclave.mkdir(parents=True)
    for name in KEYS:
        (enclave / name).write_text("no key")
    security = {
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": "Enforce",
        "ROS_SECURITY_KEYSTORE": str(tmp_path / "keys"),
        "ROS_SECURITY_ENCLAVE_OVERRIDE": "/heave",
    }
    node = subprocess.run(
        [sys.executable, str(PROGRAM), "virtual_winch"],
        env={**loop.environment, **security},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert node.returncode == 1
    assert node.stderr.splitlines()[-1].startswith("virtual_winch: ROS failed to start: error creating node: ")
