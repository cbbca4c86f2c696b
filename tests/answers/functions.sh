# What commands in these files share; bash reads it before each.

# Runs the program with each line of the input as its arguments: its output, its errors, and how it ends.
each() {
    local line code
    while read -r line; do
        echo "→ $line"
        eval "kugelblitz $line" 2>&1 </dev/null | sed '/^$/d; /^For more information/d'
        code=${PIPESTATUS[0]}
        [ "$code" -eq 0 ] || echo "exit $code"
    done
}

# An array of NumPy: npy '<f8' '(1, 6)' 0 0 5 0 0 -1; by columns with True behind the shape; of records with numbers one after
# the other, each of the type before it: npy "[('x', '<f8'), ('n', '>i2')]" '(2,)' d 1.5 h 7 d 2 h 8
npy() {
    python3 - "$@" <<'END'
import struct, sys
descr, shape, *numbers = sys.argv[1:]
order = numbers.pop(0) if numbers[:1] == ["True"] else "False"
quoted = descr if descr.startswith("[") else f"'{descr}'"
header = f"{{'descr': {quoted}, 'fortran_order': {order}, 'shape': {shape}, }}"
header = header.ljust((len(header) + 74) // 64 * 64 - 11) + "\n"
kind = {"f8": "d", "f4": "f", "f2": "e", "u1": "B", "i2": "h", "i4": "i", "u4": "I", "i8": "q"}.get(descr[1:], "x")
if quoted == descr:
    kinds, numbers = numbers[::2], numbers[1::2]
else:
    kinds = [(">" if descr[0] == ">" else "<") + kind] * len(numbers)
sys.stdout.buffer.write(b"\x93NUMPY\x01\0" + struct.pack("<H", len(header)) + header.encode())
for kind, number in zip(kinds, numbers):
    kind = kind if kind[0] in "<>" else "<" + kind
    number = number.encode() if kind[-1] == "s" else float(number) if kind[-1] in "dfe" else int(number)
    sys.stdout.buffer.write(struct.pack(kind, number))
END
}

# Sets a byte of a file, counted from its end: spoil a.npy 12 7
spoil() {
    printf "\\x$(printf %02x "$3")" | dd of="$1" bs=1 seek=$(($(stat -c %s "$1") - $2)) conv=notrunc status=none
}

# The errors for wrong scenes, each of which is one line of the input, as printf has it.
each_scene() {
    local line
    while IFS= read -r line; do
        echo "→ $line"
        printf -- "$line" > a.toml
        kugelblitz info a.toml 2>&1
        [ $? -eq 3 ] || echo "error: not refused as wrong data"
    done
}

# Of the output of `each_scene` and `each_cloud`: the rows, the errors, and each hint where it occurs first.
errors() {
    awk '/^→/ { print } /^error/ { sub(/^error: (a|cloud)\.toml:/, ""); print "  " $0 } /= help/ && !seen[$0]++ { sub(/^ *= help/, "    help"); print }'
}

# What is said of clouds, of which each line of the input is one: its file's name, the keys of its table or `-`, and the file's
# content (as printf has it, or a call of npy), with bars between them. With `spheres`, they are shown beside the notes.
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
        printf '%s[[spheres]]\nfile = "%s"\n%b\n' "${1:+$eye}" "$name" "$keys" > cloud.toml
        echo "→ $line"
        kugelblitz info cloud.toml 2>&1 | grep -v '^on the \|^memory\|^picture\|^in memory\|: [0-9]* spheres\?, '
        [ -z "$1" ] || "$1" cloud.toml 2>/dev/null
    done
}

eye=$'camera = { position = [0, 0, 9], look_at = [0, 0, 0] }\n'

# The spheres of a scene, a line each: x, y, z, radius, and the colour as its sRGB bytes or as linear numbers.
spheres() {
    kugelblitz export pov "$1" -q | python3 -c '
import re, sys
def linear(byte):
    v = byte / 255
    return v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4
def byte(number):
    return next((b for b in range(256) if abs(linear(b) - number) <= 1e-13 * number), None)
for line in sys.stdin:
    if line.startswith("sphere"):
        numbers = re.findall(r"-?\d[-+.e\d]*", line.split("//")[0])
        bytes = [byte(float(x)) for x in numbers[4:]]
        color = " ".join(numbers[4:]) if None in bytes else "#%02x%02x%02x" % tuple(bytes)
        print("  ", *(x.removesuffix(".0") for x in numbers[:4]), color)'
}
