#pragma once

#include <tenon/systems/framework/diagram/diagram.h>

#include <filesystem>

namespace tenon::apps {

/// Writes the diagram to a file, as SVG by Graphviz's `dot` or as .dot; does nothing if `file` is empty.
/// Throws ParameterError for another extension or if `dot` is missing, and OutputError if the file cannot be
/// written.
void WriteGraph(const Diagram& diagram, const std::filesystem::path& file);

}  // namespace tenon::apps
