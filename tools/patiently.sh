# sh tools/patiently.sh WORDS COMMAND...: run COMMAND, and say every 15 s (EVERY) what it does and for how long it has.
words=$1
shift
every=${EVERY:-15}
parent=$$
(
    so_far=0
    # the sleep that outlives this loop must not hold the caller's pipe
    while sleep "$every" < /dev/null > /dev/null 2>&1 && kill -0 "$parent" 2> /dev/null; do
        so_far=$((so_far + every))
        echo "setup: $words, $so_far s so far"
    done
) &
teller=$!
trap 'kill "$teller" 2> /dev/null' EXIT
"$@"
