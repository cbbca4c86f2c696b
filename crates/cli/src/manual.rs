//! The texts of the manual pages that are not in the command line's own help.

/// Environment variables and what they say.
pub const ENVIRONMENT: [(&str, &str); 7] = [
    (
        "WGPU_ADAPTER_NAME",
        "A part of the name of the adapter that --device auto and --device gpu take; \
         `kugelblitz probe` lists the names.",
    ),
    (
        "VK_DRIVER_FILES",
        "Paths of the descriptions of Vulkan drivers, for the Vulkan loader: only these are seen.",
    ),
    (
        "RAYON_NUM_THREADS",
        "Threads that share the work on the CPU. Without it there are as many as processors. The \
         output is the same with any number.",
    ),
    ("NO_COLOR", "Where it is set, messages have no colours."),
    (
        "TMPDIR",
        "Where a picture is collected that goes to a pipe in a format that needs to be sought in.",
    ),
    ("DISPLAY", "The X11 display of the window."),
    ("WAYLAND_DISPLAY", "The Wayland display of the window; it is tried first."),
];

/// A page, a line to be typed, and what it does.
pub const EXAMPLES: &[(&str, &str, &str)] = &[
    (
        "kugelblitz",
        "kugelblitz render scenes/figure1.toml -o figure1.png",
        "Draws a picture; each pixel shows the object that exact arithmetic sees.",
    ),
    (
        "kugelblitz-render",
        "kugelblitz render scenes/figure1.toml -o figure1.png --size 640x360 --samples 3",
        "A picture with smooth edges.",
    ),
    (
        "kugelblitz-render",
        "kugelblitz render scenes/figure2.toml -o figure2.exr --certificates",
        "Colour, depth, ids and normals, and for each pixel the arithmetic that decided it.",
    ),
    (
        "kugelblitz-render",
        "kugelblitz render scenes/figure2.toml -o - --format ppm > figure2.ppm",
        "A picture for a pipe.",
    ),
    (
        "kugelblitz-render",
        "kugelblitz render scenes/clouds/caffeine.xyz -o caffeine.png --size 640x360 --view iso",
        "A picture straight from data, with a camera that frames all.",
    ),
    (
        "kugelblitz-render",
        "kugelblitz render scenes/lit/figure2.toml -o film.png --size 320x180 --turntable 4",
        "film-0001.png and so on: once around the scene.",
    ),
    (
        "kugelblitz-verify",
        "kugelblitz verify scenes/figure5.toml --size 320x180 --all-kernels",
        "Holds every pixel of every kernel against exact arithmetic.",
    ),
    ("kugelblitz-info", "kugelblitz info scenes/figure1.toml", "What a scene costs."),
    (
        "kugelblitz-trace",
        "kugelblitz trace scenes/figure2.toml --rays rays.npy -o hits.npy",
        "The hits of any rays: float64 of shape (N, 6) in, a structured array (N,) out.",
    ),
    (
        "kugelblitz-explain",
        "kugelblitz explain scenes/figure5.toml --pixel 640,360",
        "Why a pixel shows what it shows.",
    ),
    (
        "kugelblitz-explain",
        "kugelblitz explain scenes/figure5.toml --ray 0,0,0,0,0,-1 --latex",
        "The same of any ray, for a script in LaTeX.",
    ),
    (
        "kugelblitz-compare",
        "kugelblitz compare figure2.exr scenes/figure2.toml",
        "Compares another renderer's ids, depths, normals and colours with exact arithmetic.",
    ),
    (
        "kugelblitz-compare",
        "kugelblitz compare figure1.png figure1.png",
        "Whether two pictures are equal, and where not.",
    ),
    (
        "kugelblitz-info",
        "kugelblitz info figure2.exr",
        "What a picture says of itself: scene, camera, kernel, proof.",
    ),
    (
        "kugelblitz-figure",
        "kugelblitz figure 4 -o figure4.svg",
        "The lecture's figure of a sphere, drawn with axes.",
    ),
    (
        "kugelblitz-figure",
        "kugelblitz figure 5 --lang de -o abbildung5.svg",
        "A ray that misses, touches and pierces spheres, with the sign of each discriminant.",
    ),
    (
        "kugelblitz-export",
        "kugelblitz export pov scenes/lit/figure2.toml -o figure2.pov",
        "A scene for POV-Ray, and the command that renders it there.",
    ),
    (
        "kugelblitz-report",
        "kugelblitz report scenes/figure2.toml --size 160x90 -o report.json -o report.html",
        "Measures speed against error, as a page and with all figures.",
    ),
    (
        "kugelblitz-view",
        "kugelblitz view scenes/figure1.toml",
        "Opens a window; H lists its controls.",
    ),
    ("kugelblitz-new", "kugelblitz new first.toml", "A small lit scene to start from."),
    (
        "kugelblitz-generate",
        "kugelblitz generate --count 1000 -o cloud.npy --scene cloud.toml",
        "A thousand spheres, and a scene that shows them.",
    ),
    (
        "kugelblitz-digest",
        "kugelblitz digest scenes/lit/figure1.toml --size 320x180",
        "One line to keep in place of a reference picture.",
    ),
    (
        "kugelblitz-digest",
        "kugelblitz digest scenes/figure1.toml scenes/figure2.toml --size 96x54 --write digests.txt",
        "Lines for many scenes, which --check compares with.",
    ),
    ("kugelblitz-probe", "kugelblitz probe", "The Vulkan adapters and what their arithmetic does."),
    (
        "kugelblitz-completions",
        "kugelblitz completions bash > kugelblitz.bash",
        "A script that bash completes commands and options by.",
    ),
    ("kugelblitz-man", "kugelblitz man render > kugelblitz-render.1", "The page of one command."),
    ("kugelblitz-man", "kugelblitz man --dir man1", "All pages, for a package."),
];

/// What stands before all keys.
pub const SCENE_INTRODUCTION: [&str; 3] = [
    "A scene is a TOML file in UTF-8. Numbers are read as the nearest f64; from there on, what a scene \
     means is exact arithmetic on them. The world is right-handed, with any unit of length.",
    "A colour is \"#rrggbb\" or \"#rgb\" (sRGB, as a picture shows it), a name of CSS such as \
     \"steelblue\", or [red, green, blue] in linear light, each from 0 to 1.",
    "An object's id is its place: spheres in the order of the file, then those of [[spheres]], then \
     planes, from 1; 0 is the background.",
];

/// What stands behind all keys.
pub const SCENE_NOTES: [&str; 2] = [
    "Rows of .npy: numbers of shape (N, 3): x, y, z; (N, 4): with the radius; (N, 7): with the radius and red, green, blue. \
     Columns of .csv: x, y, z, and optionally r, and red, green, blue or color. Rows of .xyz: Element x y z, with van der Waals \
     radii and CPK colours. Columns of LAMMPS dumps: those of ITEM: ATOMS. Colours in data are sRGB.",
    "A wrong scene is refused with file, line, column and the nearest known key, and exit status 3; no \
     output file is touched.",
];

/// A whole scene.
pub const SCENE_EXAMPLE: &str = r##"background = "#20242c"
ambient    = 0.1

[camera]
position = [0.0, 1.0, 6.0]
look_at  = [0.0, 1.0, 0.0]

[[light]]
position = [4.0, 6.0, 3.0]

[[sphere]]
center = [0.0, 1.0, 0.0]
radius = 1.0
color  = "tomato"

[[plane]]
point  = [0.0, 0.0, 0.0]
normal = [0.0, 1.0, 0.0]
color  = "#888"
"##;
