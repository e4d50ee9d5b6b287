// What tenon_precompile precompiles belongs to a target; this is its source.
