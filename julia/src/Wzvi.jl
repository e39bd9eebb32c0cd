"""
Systems of wzvi from Julia, by the table of `wzvi-c/wzvi.h`.

UNTESTED: no Julia was at hand where this was written. `test/runtests.jl` has its tests.

    using Wzvi
    library = Wzvi.load("target/release/examples/libsystems.so")
    path = Wzvi.run(library, "Kubo", "path"; scheme = "Midpoint", parameters = (a = 1.5, sigma = 1.0),
                    q = [0.0], p = [1.0], h = 0.02, until = 20.0, noise = "wiener", seed = 7)
    path["q"]                      # a row for each degree of freedom, a column for each node
"""
module Wzvi

using Libdl

const ABI = 1
const AXES = 8
const DONE, PARTIAL, FAILED = 0, 1, 2

"""The table of functions, as `struct wzvi_table`."""
struct Table
    size::Csize_t
    abi::UInt32
    reserved::UInt32
    contents::Ptr{Cvoid}
    describe::Ptr{Cvoid}
    begin_task::Ptr{Cvoid}
    set_real::Ptr{Cvoid}
    set_integer::Ptr{Cvoid}
    set_text::Ptr{Cvoid}
    set_reals::Ptr{Cvoid}
    set_integers::Ptr{Cvoid}
    run::Ptr{Cvoid}
    stop::Ptr{Cvoid}
    progress::Ptr{Cvoid}
    results::Ptr{Cvoid}
    result::Ptr{Cvoid}
    columns::Ptr{Cvoid}
    error::Ptr{Cvoid}
    code::Ptr{Cvoid}
    end_task::Ptr{Cvoid}
end

"""A library of systems: `Wzvi.load("libsystems.so")`."""
struct Library
    handle::Ptr{Cvoid}
    address::Ptr{Table}
    table::Table
end

"""A run that could not start, or ended early: `partial` has its arrays up to there, or is `nothing`."""
struct RunError <: Exception
    code::String
    message::String
    partial::Union{Nothing,Dict{String,Array{Float64}}}
end

Base.showerror(io::IO, error::RunError) = print(io, "wzvi: ", error.message)

"""Opens a library that `cargo build` made of a crate with `wzvi_c::export!`."""
function load(path::AbstractString)
    handle = dlopen(path)
    address = ccall(dlsym(handle, :wzvi_table), Ptr{Table}, ())
    table = unsafe_load(address)
    if table.abi != ABI || table.size < sizeof(Table)
        error("$path has version $(table.abi) of the table, and this module reads $ABI: build the library again")
    end
    Library(handle, address, table)
end

"""The systems of a library with their fields, schemes and equations, as JSON."""
describe(library::Library) =
    unsafe_string(ccall(library.table.describe, Cstring, (Ptr{Table},), library.address))

mutable struct Task
    library::Library
    pointer::Ptr{Cvoid}
    function Task(library, system, kind)
        pointer = ccall(library.table.begin_task, Ptr{Cvoid}, (Ptr{Table}, Cstring, Cstring), library.address, system, kind)
        pointer == C_NULL && throw(OutOfMemoryError())
        finalizer(new(library, pointer)) do task
            ccall(task.library.table.end_task, Cvoid, (Ptr{Cvoid},), task.pointer)
        end
    end
end

text(task::Task, of::Symbol) = unsafe_string(ccall(getfield(task.library.table, of), Cstring, (Ptr{Cvoid},), task.pointer))
check(task::Task, status) = status == DONE || throw(RunError(text(task, :code), text(task, :error), nothing))

set!(task::Task, name, value::Bool) = set!(task, name, Int64(value))
set!(task::Task, name, value::Integer) =
    check(task, ccall(task.library.table.set_integer, Int32, (Ptr{Cvoid}, Cstring, Int64), task.pointer, name, value))
set!(task::Task, name, value::Real) =
    check(task, ccall(task.library.table.set_real, Int32, (Ptr{Cvoid}, Cstring, Float64), task.pointer, name, value))
set!(task::Task, name, value::AbstractString) =
    check(task, ccall(task.library.table.set_text, Int32, (Ptr{Cvoid}, Cstring, Cstring), task.pointer, name, value))
set!(task::Task, name, value::AbstractVector{<:AbstractString}) = set!(task, name, join(value, "\n"))
set!(task::Task, name, value::AbstractArray{<:Integer}) = set!(task, name, convert(Array{Int64}, value))
set!(task::Task, name, value::AbstractArray{<:Real}) = set!(task, name, convert(Array{Float64}, value))

# The first index of Julia is the fastest, the last one of C: axes go over in reverse, so that a column is a row.
function set!(task::Task, name, value::Array{T}) where {T<:Union{Float64,Int64}}
    shape = Csize_t[reverse(size(value))...]
    setter = T === Float64 ? task.library.table.set_reals : task.library.table.set_integers
    GC.@preserve value shape begin
        check(task, ccall(setter, Int32, (Ptr{Cvoid}, Cstring, Ptr{T}, Csize_t, Ptr{Csize_t}),
                          task.pointer, name, value, ndims(value), shape))
    end
end

"""Copies of the arrays of a task, by name."""
function arrays(task::Task)
    found = Dict{String,Array{Float64}}()
    name, values, shape = Ref{Cstring}(), Ref{Ptr{Float64}}(), zeros(Csize_t, AXES)
    count = ccall(task.library.table.results, Csize_t, (Ptr{Cvoid},), task.pointer)
    for index in 0:Int(count)-1
        axes = ccall(task.library.table.result, Csize_t,
                     (Ptr{Cvoid}, Csize_t, Ptr{Cstring}, Ptr{Ptr{Float64}}, Ptr{Csize_t}),
                     task.pointer, index, name, values, shape)
        lengths = Tuple(Int.(reverse(shape[1:axes])))
        found[unsafe_string(name[])] = copy(unsafe_wrap(Array, values[], lengths))
    end
    found
end

"""
    run(library, system, kind; parameters = (;), settings...)

Runs a task of a kind, "path", "ensemble", "indicators", "lyapunov", "map" or "tangent", with the settings of
`wzvi.h`, and returns its arrays by name. A run that fails throws a [`RunError`](@ref), with the arrays so far.
"""
function run(library::Library, system::AbstractString, kind::AbstractString; parameters = (;), settings...)
    task = Task(library, system, kind)
    foreach(((name, value),) -> set!(task, "parameter.$name", value), pairs(parameters))
    foreach(((name, value),) -> set!(task, string(name), value), pairs(settings))
    status = ccall(library.table.run, Int32, (Ptr{Cvoid},), task.pointer)
    status == DONE && return arrays(task)
    throw(RunError(text(task, :code), text(task, :error), status == PARTIAL ? arrays(task) : nothing))
end

end
