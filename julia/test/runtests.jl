# Compares the bits of Julia with those of the Rust program:
#
#     cargo build --release -p wzvi-c --examples
#     julia --project=julia julia/test/runtests.jl target/release/examples
using Test
using Wzvi

folder = isempty(ARGS) ? joinpath(@__DIR__, "..", "..", "target", "release", "examples") : ARGS[1]
library = Wzvi.load(joinpath(folder, "libsystems.so"))
expected = [parse(UInt64, line; base = 16) for line in eachline(`$(joinpath(folder, "bits"))`)]
words(arrays...) = reduce(vcat, [reinterpret(UInt64, vec(array)) for array in arrays])
kubo = (parameters = (a = 1.5, sigma = 1.0), scheme = "Midpoint", h = 0.02, q = [0.0], p = [1.0], seed = 7, until = 2.0)

found = UInt64[]
path = Wzvi.run(library, "Kubo", "path"; kubo..., noise = "wiener")
append!(found, words(path["q"], path["p"]))
for threads in 1:3
    many = Wzvi.run(library, "Kubo", "ensemble"; kubo..., paths = 3000, threads, observe = ["q", "radius"])
    append!(found, words(many["mean"], many["error"]))
end
pendulum = Wzvi.run(library, "Pendulum", "path"; parameters = (g = 9.81,), scheme = "Midpoint", h = 0.01,
                    q = [2.0], p = [0.0], until = 10.0)
append!(found, words(pendulum["q"], pendulum["p"]))
springs = [0 1 2 3; 1 2 3 0]
network = Wzvi.run(library, "Network", "path"; parameters = (k = 2.0, springs), scheme = "Verlet", h = 0.05,
                   q = [1.0, 0.0, 0.0, 0.0], p = [0.0, 0.0, 0.0, 0.5], until = 5.0)
append!(found, words(network["q"], network["p"]))

@testset "Wzvi" begin
    @test found == expected
    error = try
        Wzvi.run(library, "Kubo", "path"; kubo..., untill = 3.0)
    catch error
        error
    end
    @test error isa Wzvi.RunError && error.code == "setting" && occursin("untill", error.message)
    partial = try
        Wzvi.run(library, "Kubo", "path"; parameters = (a = 1.5, sigma = 1.0), scheme = "Midpoint", h = 0.02,
                 q = [0.0], p = [1.0], steps = 3, increments = [0.1, NaN, 0.1])
    catch error
        error
    end
    @test partial isa Wzvi.RunError && length(partial.partial["t"]) == 2
end
