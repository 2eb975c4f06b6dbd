#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tools/replay/sweep.hpp"

namespace multireach {
namespace {

using Json = nlohmann::ordered_json;

std::string cell(const Json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  const auto text = value.get<std::string>();
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted(1, '"');
  for (const char c : text) {
    if (c == '"') quoted.push_back('"');
    quoted.push_back(c);
  }
  quoted.push_back('"');
  return quoted;
}

}  // namespace

std::string sweep_table(const Json& sweep) {
  std::string header, lines;
  for (const Json& row : sweep.at("rows")) {
    std::string names = "index", line = cell(row.at("index"));
    for (const char* part : {"set", "figures"}) {
      for (const auto& [name, value] : row.at(part).items()) {
        names.append(1, ',').append(cell(name));
        line.append(1, ',').append(cell(value));
      }
    }
    if (header.empty()) header = names.append(1, '\n');
    lines.append(line).append(1, '\n');
  }
  return header + lines;
}

Json merged_sweep(const std::vector<std::string>& paths) {
  Json header;
  std::set<int64_t> seen;
  std::vector<Json> rows;  // by their number
  int64_t shards = 0;
  for (const std::string& path : paths) {
    try {
      const auto bytes = read_binary_file(path);
      Json part = Json::parse(bytes);
      const Json found = part.at("rows");
      const auto name = part.at("shard").get<std::string>();
      const Shard shard = shard_from(name);
      const auto combinations = part.at("combinations").get<int64_t>();
      part["rows"] = Json::array();
      part["shard"] = "0/1";
      if (shard.count == 1) throw InputError(path + ": is a whole sweep, not a shard of one; there is nothing to add");
      if (header.is_null()) {
        header = part;
        shards = shard.count;
      }
      if (header != part || shards != shard.count) {
        throw InputError(path + ": is of another sweep than " + paths.front() +
                         " (session, configuration, values, options or number of shards differ)");
      }
      if (!seen.insert(shard.index).second)
        throw InputError(fmt::format("{}: is shard {} once more; expected each once", path, shard.index));
      int64_t next = shard.begin(combinations);
      for (const Json& row : found) {
        if (row.at("index") != next++)
          throw InputError(fmt::format("{}: row {} is missing; expected those of shard {}", path, next - 1, name));
        rows.push_back(row);
      }
      if (next != shard.end(combinations)) throw InputError(fmt::format("{}: row {} is missing", path, next));
    } catch (const nlohmann::json::exception& error) {
      throw InputError(path + ": is not a result of multireach-replay sweep: " + error.what());
    }
  }
  if (static_cast<int64_t>(seen.size()) != shards)
    throw InputError(fmt::format("only {} of the {} shards are given; expected all", seen.size(), shards));
  std::ranges::sort(rows, {}, [](const Json& row) { return row.at("index").get<int64_t>(); });
  for (Json& row : rows) header["rows"].push_back(std::move(row));
  return header;
}

}  // namespace multireach
