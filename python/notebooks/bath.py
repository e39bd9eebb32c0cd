# %% [markdown]
# # An ensemble in a heat bath, with error bars
#
# A particle of mass 1 in a double well, with friction of rate γ in a bath of temperature kT. All units are those of the
# Hamiltonian: energies in units of the barrier, lengths in half the distance of the wells.

# %%
import matplotlib.pyplot as plt
import numpy as np

import wzvi

DoubleWell = wzvi.compile(
    "|q, p| 0.5 * p * p + (q * q - 1.0) * (q * q - 1.0)",
    friction="gamma",
    temperature="kt",
    embedding="Baoab",
    parameters={"gamma": float, "kt": float},
    observe={"kinetic": "|q, p| 0.5 * p * p", "right": "|q, p| if q > 0.0 { 1.0 } else { 0.0 }"},
    name="DoubleWell",
    doc="A particle in a double well, in a heat bath.",
    docs={"gamma": "Rate of friction, 1/time.", "kt": "Temperature, an energy."},
    want=("path", "ensemble"),
)
DoubleWell

# %% [markdown]
# ## Means over paths
# All paths begin at rest in the left well. The kinetic energy relaxes to kT/2 within 1/γ, and the wells fill much later.

# %%
kt = 0.4
well = DoubleWell(gamma=1.0, kt=kt)
many = well.ensemble(
    h=0.05, q=-1.0, p=0.0, until=40.0, paths=20_000, seed=7, record_every=40,
    observe=["kinetic", "right", "q"], histograms={"q": (-2.0, 2.0, 80)}, progress=True,
)  # fmt: skip
many

# %%
many.to_pandas().tail()

# %% [markdown]
# ## Beside what is known
# The equipartition of the kinetic energy, and Boltzmann's law of the position. The bars are two standard errors.

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
kinetic, filled = many.of("kinetic"), many.of("right")
left.errorbar(many.t, kinetic["mean"], 2 * kinetic["error"], fmt="o", ms=3, label="kinetic energy")
left.errorbar(many.t, filled["mean"], 2 * filled["error"], fmt="s", ms=3, label="fraction in the right well")
left.axhline(kt / 2, color="0.5", lw=1)
left.axhline(0.5, color="0.5", lw=1)
left.set(xlabel="time", ylim=(0, 0.6))
left.legend()

edges, counts = many["edges.q"], many["histogram.q"][-1]
width, total = np.diff(edges), counts.sum()
middle = 0.5 * (edges[1:] + edges[:-1])
right.errorbar(middle, counts / total / width, 2 * np.sqrt(counts) / total / width, fmt=".", label="20 000 paths")
fine = np.linspace(-2, 2, 801)
boltzmann = np.exp(-((fine**2 - 1) ** 2) / kt)
right.plot(fine, boltzmann / (boltzmann.sum() * (fine[1] - fine[0])), label="Boltzmann")
right.set(xlabel="q", ylabel="density")
right.legend()
figure.savefig("bath.png", dpi=120)

# %%
deviation = (kinetic["mean"][-5:] - kt / 2) / kinetic["error"][-5:]
print("deviations of the kinetic energy from kT/2, in standard errors:", np.round(deviation, 1))
# Baoab has an error of second order in h here, beside the statistical one.
assert np.abs(kinetic["mean"][-5:] - kt / 2).max() < 5 * kinetic["error"].max() + 0.05**2
