//! `docs/json.md` is generated from the structs that the program serialises, and outputs match it.

mod page;
mod schema;

use std::fs;

use kugelblitz_tests::{assert_kept, gpu, text_of};
use serde_json::{Value, json};

use crate::program::{ends, in_folder, material};
use schema::{JsonField, JsonObject, JsonType, Schema};

#[test]
fn the_page_is_generated_from_the_structs() {
    let (kept, schema) = (text_of("docs/json.md"), Schema::read());
    assert_kept("docs/json.md", &page::page(&kept, &schema));
    // A summary of a command is printed by `finish`.
    let sources = ["lib.rs", "render.rs", "export.rs"];
    let sources = sources.map(|name| text_of(&format!("crates/cli/src/{name}"))).concat();
    for rest in sources.split(".finish(\"").skip(1) {
        assert!(!page::summary(&schema, rest.split('"').next().unwrap()).is_empty());
    }
}

/// Mistakes in a value that should have this type.
fn mistakes(expected: &JsonType, value: &Value, path: &str) -> Vec<String> {
    let below = |expected: &JsonType, value: &Value, key: &str| {
        mistakes(expected, value, &format!("{path}{key}"))
    };
    let is_right = match (expected, value) {
        // A number that is not finite.
        (JsonType::Nullable(_) | JsonType::Number, Value::Null) => true,
        (JsonType::Nullable(inner), _) => return mistakes(inner, value, path),
        (JsonType::Text(_), _) => value.is_string(),
        (JsonType::Integer, _) => value.is_u64() || value.is_i64(),
        (JsonType::Number, _) => value.is_number(),
        (JsonType::Boolean, _) => value.is_boolean(),
        (JsonType::List(inner, n), Value::Array(values)) if n.is_none_or(|n| n == values.len()) => {
            return values.iter().flat_map(|value| below(inner, value, "[]")).collect();
        }
        (JsonType::Map(inner), Value::Object(map)) => {
            return map.iter().flat_map(|(key, value)| below(inner, value, key)).collect();
        }
        (JsonType::Object(object), Value::Object(map)) => {
            let is_known = |key: &String| object.fields.iter().any(|field| field.key == *key);
            let unknown = map.keys().filter(|key| !is_known(key));
            let unknown = unknown.map(|key| format!("{path}.{key} is unknown"));
            let of_field = |field: &JsonField| match map.get(&field.key) {
                Some(value) => below(&field.json_type, value, &format!(".{}", field.key)),
                None if field.is_optional => Vec::new(),
                None => vec![format!("{path}.{} is missing", field.key)],
            };
            return unknown.chain(object.fields.iter().flat_map(of_field)).collect();
        }
        _ => false,
    };
    if is_right { Vec::new() } else { vec![format!("{path} has another type: {value}")] }
}

/// Command lines with their exit codes.
const LINES: [(&str, i32); 22] = [
    ("render scenes/lit/figure1.toml -o a.png --size 32x18 --device gpu --repeat 1", 0),
    ("render scenes/figure1.toml -o a.exr --size 32x18 --device cpu", 0),
    ("render scenes/figure5.toml -o b.png --size 321x181 --device cpu --show discriminant", 0),
    ("render scenes/lit/figure1.toml -o film.png --size 16x9 --turntable 2 --frames 1", 0),
    ("render scenes/lit/figure1.toml -o film.png --size 16x9 --turntable 2 --resume", 0),
    ("trace scenes/figure2.toml --rays rays.npy -o hits.npy", 0),
    ("verify scenes/lit/figure1.toml --size 16x9 --device gpu --all-kernels", 0),
    ("explain tie.toml --pixel 64,36 --size 128x72", 0),
    ("explain tie.toml --ray 0,0.9,5,0,0,-1 --device cpu", 0),
    ("compare a.exr scenes/figure2.toml", 6),
    ("compare a.png a.png", 0),
    ("info scenes/lit/figure1.toml", 0),
    ("info a.png", 0),
    ("info wrong.toml", 3),
    ("info wrong.csv", 3),
    ("digest scenes/lit/figure1.toml --size 16x9 --write kept.txt", 0),
    ("digest --check kept.txt", 0),
    ("figure 4 -o figure4.svg", 0),
    ("export pov scenes/lit/figure1.toml -o a.pov", 0),
    ("generate --count 10 -o cloud.npy", 0),
    ("probe", 0),
    ("report scenes/lit/figure1.toml --size 16x9 --rounds 1", 0),
];

/// Returns the mistakes in the output of a command that has these objects after the head.
fn mistakes_in(output: &Value, objects: Vec<JsonObject>, schema: &Schema) -> Vec<String> {
    let head = page::summary(schema, "Every object").remove(0);
    let found = objects.into_iter().map(|object| {
        let fields = head.fields.iter().cloned().chain(object.fields).collect();
        mistakes(&JsonType::Object(JsonObject { fields, ..object }), output, "")
    });
    found.min_by_key(Vec::len).unwrap_or_default()
}

#[test]
fn outputs_match_the_structs() {
    gpu();
    let (folder, schema) = (material(), Schema::read());
    fs::write(folder.path().join("wrong.csv"), "x,y,z,r\n0,0,zero,1\n").unwrap();
    for (line, code) in LINES {
        let output = ends(in_folder(&folder, &format!("{line} --json -q")), code).json();
        let objects = match line.split(' ').next().unwrap() {
            _ if line.contains("wrong") => vec![JsonObject::default()],
            _ if line.contains("--turntable") => page::summary(&schema, "film"),
            command => page::summary(&schema, command),
        };
        assert_eq!(mistakes_in(&output, objects, &schema), [""; 0], "{line}");
    }
}

/// Spoils an output.
type Change = fn(&mut Value);

#[test]
fn an_output_that_does_not_match_is_noticed() {
    let schema = Schema::read();
    let output = json!({"schema": 1, "version": "0.1.0", "command": "digest", "adapter": null,
        "scene": "a.toml", "device": "cpu", "size": [16, 9], "samples": 1, "digest": "kb2:",
        "objects": {"spheres": 1, "planes": 0}});
    let changes: [(Change, &[&str]); 6] = [
        (|_| {}, &[]),
        (|json| json["objects"]["cones"] = 1.into(), &[".objects.cones is unknown"]),
        (
            |json| drop(json["objects"].as_object_mut().unwrap().remove("planes")),
            &[".objects.planes is missing"],
        ),
        (|json| json["size"][1] = 9.5.into(), &[".size[] has another type: 9.5"]),
        (|json| json["size"] = json!([16, 9, 9]), &[".size has another type: [16,9,9]"]),
        (|json| json["device"] = Value::Null, &[".device has another type: null"]),
    ];
    for (change, found) in changes {
        let mut output = output.clone();
        change(&mut output);
        let objects = page::summary(&schema, "digest");
        assert_eq!(mistakes_in(&output, objects, &schema), found);
    }
}
