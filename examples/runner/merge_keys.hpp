// SPDX-License-Identifier: Apache-2.0
// YAML's merge keys, `<<: *name`, which the parser hands on as they stand.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

namespace runner {

/// Puts into every mapping with a merge key what it names: a mapping, or a list of mappings of which earlier ones win. Keys of the
/// mapping itself win over both. `file` is for messages.
void resolve_merge_keys(const YAML::Node& root, const std::string& file);

}  // namespace runner
