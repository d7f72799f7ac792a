# sh tools/launcher.sh .venv: let .venv/bin/heave say in one line that its environment was moved or copied.
bin=$(cd "$1/bin" && pwd -P)
cat > "$bin/.heave" << END
#!/bin/sh
made_at="$bin/"
here=\$(dirname "\$(readlink -f "\$0")")
[ "\$here/" -ef "\$made_at" ] && exec "\$here/python" -c 'import sys; from heave_bringup.cli import main; sys.exit(main())' "\$@"
echo "heave: this environment was made at \$made_at and moved to \$here: run make, which makes it again" >&2
exit 1
END
chmod 755 "$bin/.heave"
mv "$bin/.heave" "$bin/heave"
