//! Names: those of types as people write them, and those that are free.

use std::any::type_name;

/// The name of a type without the modules that it and its arguments live in: where they live may change.
pub(crate) fn short_name<T: ?Sized>() -> String {
    without_modules(type_name::<T>())
}

fn without_modules(name: &str) -> String {
    let mut short = String::new();
    let mut word = String::new();
    let mut rest = name.chars().peekable();
    while let Some(c) = rest.next() {
        if c == ':' && rest.peek() == Some(&':') {
            rest.next();
            word.clear();
        } else if c.is_alphanumeric() || c == '_' {
            word.push(c);
        } else {
            short.push_str(&word);
            word.clear();
            short.push(c);
        }
    }
    short + &word
}

/// The name itself, or a longer one if it is taken.
pub(crate) fn free<'k>(name: &str, known: impl Iterator<Item = &'k str> + Clone) -> String {
    let mut free = name.to_owned();
    while known.clone().any(|known| known == free) {
        free.push('_');
    }
    free
}

#[cfg(test)]
mod tests {
    use super::without_modules;

    #[test]
    fn modules_are_left_out() {
        for (name, short) in [
            ("Kubo", "Kubo"),
            ("a::Lambda<1, 4>", "Lambda<1, 4>"),
            ("a::e::Mixed<a::e::DeltaPlus, [b::c::X_1; 3]>", "Mixed<DeltaPlus, [X_1; 3]>"),
        ] {
            assert_eq!(without_modules(name), short);
        }
    }
}
