use wzvi::compose::{self, Partitioned, Weights};

struct Lopsided;

impl Weights for Lopsided {
    const ORDER: u32 = 2;
    const GAMMA: &'static [f64] = &[0.75, 0.25];
}

struct Short;

impl Partitioned for Short {
    const ORDER: u32 = 2;
    const STARTS_WITH_DRIFT: bool = false;
    const SEQUENCE: &'static [f64] = &[0.5, 0.9, 0.5];
}

const _: () = compose::check_weights::<Lopsided>();
const _: () = compose::check_table::<Short>();

fn main() {}
