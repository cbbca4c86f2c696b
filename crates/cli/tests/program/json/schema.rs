//! Types of the JSON summaries, read from the Rust structs that serde serialises.
//!
//! Names, types, optional fields and meanings come from the structs, their attributes for serde and their doc comments. An
//! attribute that is not known here is an error.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use kugelblitz_tests::root;
use syn::{Attribute, Data, DeriveInput, Expr, ExprLit, Field, Fields, GenericArgument, Lit};
use syn::{LitStr, Meta, PathArguments, Token, Type, Variant, parse_str};

/// Folders with serialised structs.
const FOLDERS: [&str; 4] = ["src", "crates/judge/src", "crates/report/src", "crates/cli/src"];

/// Types that serialise themselves and functions of `serialize_with`, with a type that is serialised in the same way.
const SERIALIZERS: [(&str, &str); 4] = [
    ("Millis", "f64"),
    ("Remark", "String"),
    ("as_hex", "String"),
    ("quantities_alone", "Vec<FormulaNumber>"),
];

/// Attributes for serde that are followed here.
const ATTRIBUTES: &str =
    "flatten rename rename_all serialize_with skip skip_serializing_if tag untagged";

/// Sentence that ends the doc comment of a field or type that may change with a minor version.
const UNSTABLE: &str = "Unstable in JSON.";

/// Type of a JSON value.
#[derive(Clone)]
pub enum JsonType {
    /// Text, with a description of its values if it is an enum.
    Text(String),
    Integer,
    /// Number; `null` if it is not finite.
    Number,
    Boolean,
    Nullable(Box<JsonType>),
    /// List of a number of values; `None` for any number.
    List(Box<JsonType>, Option<usize>),
    Map(Box<JsonType>),
    Object(JsonObject),
}

/// Object with its fields in the order of the output.
#[derive(Clone, Default)]
pub struct JsonObject {
    pub name: String,
    pub doc: String,
    pub fields: Vec<JsonField>,
}

/// Field of an object.
#[derive(Clone)]
pub struct JsonField {
    pub key: String,
    pub json_type: JsonType,
    pub is_optional: bool,
    pub is_stable: bool,
    pub doc: String,
}

impl JsonType {
    /// Returns the object that a value is or contains, with `[]` for each list around it.
    pub fn object(&self) -> Option<(&JsonObject, String)> {
        match self {
            JsonType::Object(object) => Some((object, String::new())),
            JsonType::Nullable(inner) => inner.object(),
            JsonType::List(inner, _) => inner.object().map(|(object, path)| (object, path + "[]")),
            _ => None,
        }
    }
}

/// Returns the values of the attributes for serde, empty for those without one.
fn serde_options(attributes: &[Attribute]) -> BTreeMap<String, String> {
    let mut options = BTreeMap::new();
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("serde")) {
        let parsed = attribute.parse_nested_meta(|meta| {
            let name = meta.path.require_ident()?.to_string();
            assert!(ATTRIBUTES.split(' ').any(|known| known == name), "serde({name})");
            let has_value = meta.input.peek(Token![=]);
            let value = has_value.then(|| meta.value()?.parse::<LitStr>()).transpose()?;
            options.insert(name, value.map_or(String::new(), |value| value.value()));
            Ok(())
        });
        parsed.expect("attributes of serde");
    }
    options
}

/// Returns the first paragraph of a doc comment, and whether its subject is stable.
fn documentation(attributes: &[Attribute]) -> (String, bool) {
    let line = |attribute: &Attribute| {
        let Meta::NameValue(pair) = &attribute.meta else { return None };
        let Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) = &pair.value else { return None };
        pair.path.is_ident("doc").then(|| text.value().trim().to_owned())
    };
    let lines = attributes.iter().filter_map(line).take_while(|line| !line.is_empty());
    let text = lines.collect::<Vec<_>>().join(" ");
    let is_for_rust = ["`None`", "[`", "|"].iter().any(|part| text.contains(part));
    assert!(!is_for_rust, "not for a table about JSON: {text}");
    match text.strip_suffix(UNSTABLE) {
        Some(text) => (text.trim_end().to_owned(), false),
        None => (text, true),
    }
}

/// Returns the key of a variant.
fn variant_key(variant: &Variant, style: &str) -> String {
    let mut key = String::new();
    for letter in variant.ident.to_string().chars() {
        if letter.is_uppercase() && style == "snake_case" && !key.is_empty() {
            key.push('_');
        }
        key.extend(letter.to_lowercase());
    }
    assert!(["snake_case", "lowercase"].contains(&style), "rename_all = {style}");
    key
}

/// Serialised structs and enums of the program, with their files.
pub struct Schema {
    items: Vec<(String, DeriveInput)>,
}

/// File of a type, and its type parameters.
type Scope<'a> = (&'a str, &'a BTreeMap<String, JsonType>);

impl Schema {
    /// Reads the sources.
    pub fn read() -> Schema {
        let mut schema = Schema { items: Vec::new() };
        FOLDERS.iter().for_each(|folder| schema.read_folder(&root().join(folder)));
        schema
    }

    fn read_folder(&mut self, folder: &Path) {
        let derives = |line: &str| line.starts_with("#[derive(") && line.contains("Serialize");
        for entry in fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                self.read_folder(&path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let text = fs::read_to_string(&path).expect("a text");
                // Blank lines separate items, and a struct has none.
                for item in text.split("\n\n").filter(|item| item.lines().any(derives)) {
                    let item = parse_str(item).unwrap_or_else(|error| panic!("{error}: {item}"));
                    self.items.push((path.to_string_lossy().into_owned(), item));
                }
            }
        }
    }

    /// Returns the item of this name in a file, or else the only one of this name.
    fn item(&self, name: &str, file: &str) -> (&str, &DeriveInput) {
        let found = self.items.iter().filter(|(_, item)| item.ident == name);
        let (of_file, all): (Vec<_>, Vec<_>) = found.partition(|(path, _)| path.ends_with(file));
        let [(file, item)] = if of_file.is_empty() { &all } else { &of_file }[..] else {
            panic!("{name} of {file}: {} types", all.len() + of_file.len());
        };
        (file, item)
    }

    /// Returns the objects of a summary: several for an untagged enum.
    pub fn objects(&self, name: &str, file: &str) -> Vec<JsonObject> {
        let (file, item) = self.item(name, file);
        let scope = (file, &BTreeMap::new());
        let Data::Enum(data) = &item.data else { return vec![self.object(name, file, &[])] };
        assert!(serde_options(&item.attrs).contains_key("untagged"), "{name} has a tag");
        let object = |variant: &Variant| {
            let fields = match &variant.fields {
                Fields::Unnamed(fields) => {
                    let inner = self.json_type(&fields.unnamed[0].ty, scope);
                    inner.object().expect("an object").0.fields.clone()
                }
                fields => fields.iter().flat_map(|field| self.fields(field, scope)).collect(),
            };
            JsonObject { name: name.into(), doc: documentation(&variant.attrs).0, fields }
        };
        data.variants.iter().map(object).collect()
    }

    /// Returns the object of a struct. A type parameter without an argument is an empty object.
    fn object(&self, name: &str, file: &str, arguments: &[JsonType]) -> JsonObject {
        let (file, item) = self.item(name, file);
        let Data::Struct(data) = &item.data else { panic!("{name} is no struct") };
        let argument = |at: usize| {
            arguments.get(at).cloned().unwrap_or(JsonType::Object(JsonObject::default()))
        };
        let names = item.generics.type_params().enumerate();
        let parameters = names.map(|(at, name)| (name.ident.to_string(), argument(at))).collect();
        let (doc, is_stable) = documentation(&item.attrs);
        let mut fields = Vec::new();
        for mut field in
            data.fields.iter().flat_map(|field| self.fields(field, (file, &parameters)))
        {
            field.is_stable &= is_stable;
            fields.push(field);
        }
        let arguments = arguments.iter().filter_map(JsonType::object);
        let name = arguments.fold(name.to_owned(), |name, (object, _)| name + &object.name);
        JsonObject { name, doc, fields }
    }

    /// Returns the fields of the output for a field of a struct: none if it is skipped, several if it is flattened.
    fn fields(&self, field: &Field, scope: Scope) -> Vec<JsonField> {
        let options = serde_options(&field.attrs);
        if options.contains_key("skip") {
            return Vec::new();
        }
        let json_type = match options.get("serialize_with") {
            Some(function) => self.named_type(function, scope.0, Vec::new()),
            None => self.json_type(&field.ty, scope),
        };
        let (doc, is_stable) = documentation(&field.attrs);
        if options.contains_key("flatten") {
            let mut fields = json_type.object().expect("an object").0.fields.clone();
            for field in &mut fields {
                field.is_optional |= matches!(json_type, JsonType::Nullable(_));
                field.is_stable &= is_stable;
            }
            return fields;
        }
        let is_optional = options.contains_key("skip_serializing_if");
        let json_type = match json_type {
            JsonType::Nullable(inner) if is_optional => *inner,
            other => other,
        };
        let name = field.ident.as_ref().map(ToString::to_string);
        let key = options.get("rename").cloned().or(name).expect("a name");
        assert!(!doc.is_empty(), "{}: {key} has no doc comment", scope.0);
        vec![JsonField { key, json_type, is_optional, is_stable, doc }]
    }

    /// Returns the type of a struct, or of an enum that is not untagged.
    fn item_type(&self, name: &str, file: &str, arguments: &[JsonType]) -> JsonType {
        let (file, item) = self.item(name, file);
        let Data::Enum(data) = &item.data else {
            return JsonType::Object(self.object(name, file, arguments));
        };
        let options = serde_options(&item.attrs);
        let style = options.get("rename_all").expect("a style of keys");
        let (mut values, mut fields) = (Vec::new(), Vec::new());
        for variant in &data.variants {
            let key = variant_key(variant, style);
            values.push(format!("`{key}`: {}", documentation(&variant.attrs).0));
            let scope = (file, &BTreeMap::new());
            for field in variant.fields.iter().flat_map(|field| self.fields(field, scope)) {
                let doc = format!("With `{key}`: {}", field.doc);
                fields.push(JsonField { is_optional: true, doc, ..field });
            }
        }
        let doc = values.join(" ");
        let Some(tag) = options.get("tag") else { return JsonType::Text(doc) };
        let (key, json_type) = (tag.clone(), JsonType::Text(String::new()));
        fields.insert(0, JsonField { key, json_type, is_optional: false, is_stable: true, doc });
        let (doc, _) = documentation(&item.attrs);
        JsonType::Object(JsonObject { name: name.into(), doc, fields })
    }

    fn json_type(&self, rust: &Type, scope: Scope) -> JsonType {
        match rust {
            Type::Reference(reference) => self.json_type(&reference.elem, scope),
            Type::Array(array) => {
                let length = match &array.len {
                    Expr::Lit(ExprLit { lit: Lit::Int(length), .. }) => length.base10_parse().ok(),
                    _ => None,
                };
                JsonType::List(self.json_type(&array.elem, scope).into(), length)
            }
            Type::Path(path) => {
                let last = path.path.segments.last().expect("a name");
                let arguments = match &last.arguments {
                    PathArguments::AngleBracketed(list) => list.args.iter().collect(),
                    _ => Vec::new(),
                };
                let argument = |argument: &GenericArgument| match argument {
                    GenericArgument::Type(rust) => Some(self.json_type(rust, scope)),
                    _ => None,
                };
                let name = last.ident.to_string();
                scope.1.get(&name).cloned().unwrap_or_else(|| {
                    self.named_type(
                        &name,
                        scope.0,
                        arguments.into_iter().filter_map(argument).collect(),
                    )
                })
            }
            _ => panic!("{}: a type that is not known", scope.0),
        }
    }

    fn named_type(&self, name: &str, file: &str, mut arguments: Vec<JsonType>) -> JsonType {
        let mut last = || Box::new(arguments.pop().expect("a type argument"));
        match name {
            "String" | "str" => JsonType::Text(String::new()),
            "bool" => JsonType::Boolean,
            "f32" | "f64" => JsonType::Number,
            "u8" | "u32" | "u64" | "usize" | "i32" | "i64" => JsonType::Integer,
            "Option" => JsonType::Nullable(last()),
            "Vec" => JsonType::List(last(), None),
            "BTreeMap" => JsonType::Map(last()),
            "Box" => *last(),
            _ => match SERIALIZERS.iter().find(|(own, _)| *own == name) {
                Some((_, like)) => {
                    let like = parse_str(like).expect("a type");
                    self.json_type(&like, (file, &BTreeMap::new()))
                }
                None => self.item_type(name, file, &arguments),
            },
        }
    }
}
