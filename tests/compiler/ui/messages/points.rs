struct Rule;
struct Other;

#[hamiltonian(
    drift = |q, p| q * p,
    embedding = [
        Rule = [(0, 1/3), (1, 1/2)],
        Midpoint = [(1/2, 1)],
        Lambda<1, 3> = [(1/3, 1)],
        Other = [(1/4, 1/2), (0.25, 1/2)],
    ],
)]
struct Wrong;

#[hamiltonian(drift = |q, p| q * p, embedding = Rule = [(3/2, 1)])]
struct Outside;

#[hamiltonian(drift = |q, p| q * p, embedding = [Rule = [(l, 1)], Other = 1/2])]
struct Unknown;

#[hamiltonian(drift = |q, p| q * p, embedding = [Rule = [(0, 1), (1, 0)], Other = [(0, 1), (1/2, 1), (1, -1)], Other = [(0, 1)]])]
struct Weightless;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    noise = [|q, p| 0.3 * q * p],
    embedding = [Rule = [(0, 1/2), (1/2, 1/2)]],
)]
struct Inconsistent;
