//! The results of a task: arrays of real numbers, by name.

/// An array with a name, the last index fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Its name.
    pub name: String,
    /// Its numbers.
    pub values: Vec<f64>,
    /// The length of each axis; none for a single number.
    pub shape: Vec<usize>,
}

/// The arrays of a task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Results {
    /// In the order in which they were added.
    pub arrays: Vec<Array>,
    /// The names of the observables of an ensemble; of other kinds those of time, coordinates and momenta.
    pub columns: Vec<String>,
}

impl Results {
    /// Adds an array.
    pub fn add(&mut self, name: impl Into<String>, values: Vec<f64>, shape: &[usize]) {
        debug_assert_eq!(values.len(), shape.iter().product::<usize>(), "as many numbers as the shape says");
        self.arrays.push(Array { name: name.into(), values, shape: shape.to_vec() });
    }

    /// Adds an array of one axis.
    pub fn add_list(&mut self, name: impl Into<String>, values: impl IntoIterator<Item = f64>) {
        let values: Vec<f64> = values.into_iter().collect();
        let length = values.len();
        self.add(name, values, &[length]);
    }

    /// Adds a single number.
    pub fn add_number(&mut self, name: impl Into<String>, value: f64) {
        self.add(name, vec![value], &[]);
    }

    /// The array with this name.
    pub fn array(&self, name: &str) -> Option<&Array> {
        self.arrays.iter().find(|array| array.name == name)
    }
}
