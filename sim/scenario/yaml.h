// The YAML reader under its names in scenarios.
#pragma once

#include "sim/files/yaml.h"

namespace sim::scenario {

using files::ConfigError, files::Origin, files::Yaml, files::MapReaders;
using files::did_you_mean, files::fail, files::parse_seeds, files::parse_yaml, files::parse_yaml_file,
    files::quote_if_needed, files::read_map, files::read_path, files::read_seeds, files::read_texts,
    files::require_map, files::yaml_text;

}  // namespace sim::scenario
