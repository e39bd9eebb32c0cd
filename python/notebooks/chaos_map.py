# %% [markdown]
# # A map of chaos
#
# The system of Hénon and Heiles at one energy: each pixel is a start with x = 0, and its colour says whether the path is
# regular (the mean of MEGNO goes to 2) or chaotic (it grows with time). From SymPy; the closures could be texts as well.

# %%
import matplotlib.pyplot as plt
import numpy as np
import sympy

import wzvi

x, y, px, py = sympy.symbols("x y p_x p_y")
H = (px**2 + py**2 + x**2 + y**2) / 2 + x**2 * y - y**3 / 3
HenonHeiles = wzvi.compile(
    H, q=[x, y], p=[px, py], embedding="Verlet", name="HenonHeiles", doc="The galactic potential of Hénon and Heiles.",
    want=("path", "ensemble", "chaos"),
)  # fmt: skip
HenonHeiles

# %% [markdown]
# ## Starts
# On the section x = 0 at the energy 1/8: p_x follows from y and p_y where it is real.

# %%
energy, side = 1 / 8, 120
grid_y, grid_py = np.meshgrid(np.linspace(-0.45, 0.7, side), np.linspace(-0.5, 0.5, side))
square = 2 * energy - grid_py**2 - grid_y**2 + 2 * grid_y**3 / 3
inside = square > 0
q = np.column_stack([np.zeros(inside.sum()), grid_y[inside]])
p = np.column_stack([np.sqrt(square[inside]), grid_py[inside]])

# %%
henon = HenonHeiles()
chaos = henon.map(h=0.1, q=q, p=p, until=300.0, progress=True)
chaos

# %%
picture = np.full(grid_y.shape, np.nan)
picture[inside] = chaos.megno_mean
chaotic = np.mean(chaos.megno_mean > 4)
figure, axes = plt.subplots(figsize=(6, 4.8), layout="constrained")
image = axes.pcolormesh(grid_y, grid_py, np.clip(picture, 0, 8), cmap="magma", shading="auto", rasterized=True)
figure.colorbar(image, label="mean of MEGNO")
axes.set(xlabel="y", ylabel="p_y", title=f"{100 * chaotic:.0f} % of {len(q)} paths are chaotic at E = 1/8")
figure.savefig("chaos_map.png", dpi=120)

# %% [markdown]
# ## One path of each kind
# Lyapunov exponents with errors over copies of the path.

# %%
for name, start in [("regular", np.nanargmin(chaos.fli)), ("chaotic", np.nanargmax(chaos.fli))]:
    print(name, henon.lyapunov(h=0.1, q=q[start], p=p[start], until=2000.0))
assert 0.2 < chaotic < 0.9
