// The source of the target whose precompiled headers tenon_precompile shares.
