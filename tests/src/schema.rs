//! A check of JSON values against the schemas of an `OpenAPI` document: those keywords that the panel's document uses.

use serde_json::{Map, Value};

/// An `OpenAPI` document.
#[derive(Debug)]
pub struct Document(pub Value);

impl Document {
    /// Returns the schema of this name.
    ///
    /// # Panics
    /// There is none.
    pub fn schema(&self, name: &str) -> &Value {
        let found = self.0["components"]["schemas"].get(name);
        found.unwrap_or_else(|| panic!("the document has no schema '{name}'"))
    }

    /// Checks a value.
    ///
    /// # Errors
    /// The value does not fit: the place in it, and why.
    ///
    /// # Panics
    /// The schema has a keyword that is not known here.
    pub fn check(&self, schema: &Value, value: &Value) -> Result<(), String> {
        // What is of another type fits nowhere else either.
        if let Some(wanted) = schema.get("type") {
            is_type(wanted.as_str().unwrap(), value)?;
        }
        for (keyword, wanted) in schema.as_object().unwrap() {
            match keyword.as_str() {
                "$ref" => {
                    let name = wanted.as_str().unwrap().rsplit('/').next().unwrap();
                    self.check(self.schema(name), value)?;
                }
                "const" => same(wanted, value)?,
                "enum" if wanted.as_array().unwrap().contains(value) => {}
                "enum" => return Err(format!("{value} is none of {wanted}")),
                "oneOf" => self.one_of(wanted.as_array().unwrap(), value)?,
                "items" => {
                    for (n, item) in value.as_array().into_iter().flatten().enumerate() {
                        self.check(wanted, item).map_err(|why| format!("[{n}]{why}"))?;
                    }
                }
                "required" => {
                    for name in wanted.as_array().unwrap() {
                        let name = name.as_str().unwrap();
                        value.get(name).ok_or_else(|| format!(": no '{name}' in {value}"))?;
                    }
                }
                "properties" => self.properties(wanted.as_object().unwrap(), value)?,
                "additionalProperties" => {
                    self.others(schema.get("properties"), wanted, value)?;
                }
                "maxItems" => at_most(wanted, value.as_array().map(Vec::len))?,
                "maxLength" => at_most(wanted, value.as_str().map(str::len))?,
                "maxProperties" => at_most(wanted, value.as_object().map(Map::len))?,
                "minProperties" | "minItems" if wanted == 1 => {
                    let empty = value.as_object().is_some_and(Map::is_empty)
                        || value.as_array().is_some_and(Vec::is_empty);
                    if empty {
                        return Err(": it is empty".to_owned());
                    }
                }
                "type" | "description" | "format" => {}
                other => panic!("the schema has the keyword '{other}': add it here"),
            }
        }
        Ok(())
    }

    fn one_of(&self, choices: &[Value], value: &Value) -> Result<(), String> {
        let refusals: Vec<_> =
            choices.iter().filter_map(|choice| self.check(choice, value).err()).collect();
        match choices.len() - refusals.len() {
            1 => Ok(()),
            0 => Err(format!(": {value} fits none: {}", refusals.join("; "))),
            n => Err(format!(": {value} fits {n} of {}", choices.len())),
        }
    }

    fn properties(&self, known: &Map<String, Value>, value: &Value) -> Result<(), String> {
        for (name, schema) in known {
            if let Some(field) = value.get(name) {
                self.check(schema, field).map_err(|why| format!(".{name}{why}"))?;
            }
        }
        Ok(())
    }

    fn others(&self, known: Option<&Value>, wanted: &Value, value: &Value) -> Result<(), String> {
        for (name, field) in value.as_object().into_iter().flatten() {
            if known.is_some_and(|known| known.get(name).is_some()) {
                continue;
            }
            match wanted {
                Value::Bool(true) => {}
                Value::Bool(false) => return Err(format!(": '{name}' is not in the document")),
                schema => self.check(schema, field).map_err(|why| format!(".{name}{why}"))?,
            }
        }
        Ok(())
    }
}

fn is_type(wanted: &str, value: &Value) -> Result<(), String> {
    let fits = match wanted {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("there is no type '{other}'"),
    };
    if fits { Ok(()) } else { Err(format!(": {value} is no {wanted}")) }
}

fn same(wanted: &Value, value: &Value) -> Result<(), String> {
    if wanted == value { Ok(()) } else { Err(format!(": {value} is not {wanted}")) }
}

fn at_most(wanted: &Value, size: Option<usize>) -> Result<(), String> {
    let most = usize::try_from(wanted.as_u64().unwrap()).unwrap();
    match size {
        Some(size) if most < size => Err(format!(": {size}, at most {most}")),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::Document;
    use serde_json::json;

    #[test]
    fn what_does_not_fit_is_found_with_its_place() {
        let document = Document(json!({ "components": { "schemas": { "A": {
            "type": "object", "required": ["n"], "additionalProperties": false,
            "properties": { "n": { "type": "array", "items": { "oneOf": [{ "type": "integer" }, { "type": "null" }] }, "maxItems": 2 } },
        } } } }));
        let check = |value| document.check(&json!({ "$ref": "#/components/schemas/A" }), &value);
        assert_eq!(check(json!({ "n": [1, null] })), Ok(()));
        for (value, why) in [
            (json!({}), "no 'n'"),
            (json!({ "n": [1, "x"] }), ".n[1]"),
            (json!({ "n": [1, 2, 3] }), ".n: 3, at most 2"),
            (json!({ "n": [], "m": 1 }), "'m' is not in the document"),
            (json!([]), "is no object"),
        ] {
            let said = check(value.clone()).unwrap_err();
            assert!(said.contains(why), "{value}: {said}");
        }
    }
}
