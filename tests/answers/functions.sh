# What commands in these files share; bash reads it before each.

# Runs the program with each line of the input as its arguments: what it says, and how it ends.
each() {
    local line
    while read -r line; do
        echo "→ $line"
        eval "kugelblitz $line" 2>&1 </dev/null || echo "exit $?"
    done
}

# An array of NumPy: npy '<f8' '(1, 6)' 0 0 5 0 0 -1
npy() {
    python3 - "$@" <<'END'
import struct, sys
descr, shape, *numbers = sys.argv[1:]
header = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
kind = {"f8": "d", "f4": "f", "f2": "e", "u1": "B", "i2": "h", "u4": "I", "i8": "q"}.get(descr[1:], "x")
numbers = [float(number) if kind in "dfe" else int(number) for number in numbers]
order = ">" if descr[0] == ">" else "<"
sys.stdout.buffer.write(b"\x93NUMPY\x01\0" + struct.pack("<H", len(header)) + header.encode())
sys.stdout.buffer.write(struct.pack(f"{order}{len(numbers)}{kind}", *numbers))
END
}

# Sets a byte of a file, counted from its end: spoil a.npy 12 7
spoil() {
    printf "\\x$(printf %02x "$3")" | dd of="$1" bs=1 seek=$(($(stat -c %s "$1") - $2)) conv=notrunc status=none
}

# What is said of clouds, of which each line of the input is one: its file's name, the keys of its table or `-`, and the file's
# content (as printf has it, or a call of npy), with bars between them.
each_cloud() {
    local line name keys content
    while IFS= read -r line; do
        name=${line%% | *} content=${line#* | }
        keys=${content%% | *} content=${content#* | }
        [ "$keys" = - ] && keys=
        case $content in
            npy\ *) eval "$content" > "$name" ;;
            *) printf -- "$content" > "$name" ;;
        esac
        printf '[[spheres]]\nfile = "%s"\n%b\n' "$name" "$keys" > cloud.toml
        echo "→ $line"
        kugelblitz check cloud.toml 2>&1 | grep -v '^on the \|^memory\|^picture\|^in memory\|: [0-9]* spheres\?, '
    done
}
