#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "runtime/log_file.hpp"
#include "runtime/message_schema.hpp"
#include "runtime/message_walk.hpp"
#include "runtime/progress.hpp"
#include "tools/log/export.hpp"
#include "tools/log/log_edit.hpp"
#include "tools/log/mat_writer.hpp"

namespace multireach {
namespace {

using Kind = MessageSchema::Kind;

double number_in(const MessageLeaf& leaf) {
  switch (leaf.kind) {
    case Kind::kDouble:
      return std::bit_cast<double>(big_endian<uint64_t>(leaf.bytes));
    case Kind::kFloat:
      return std::bit_cast<float>(big_endian<uint32_t>(leaf.bytes));
    case Kind::kInt8:
    case Kind::kInt16:
    case Kind::kInt32:
    case Kind::kInt64:
      return static_cast<double>(integer_in(leaf.kind, leaf.bytes));
    default:
      return leaf.bytes[0];
  }
}

constexpr size_t kLongestName = 63;

/// A valid MATLAB name: letters, digits and underscores, at most 63.
std::string identifier(const std::string& text) {
  std::string name;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      name.push_back(c);
    } else if (c != ']' && !name.empty() && name.back() != '_') {
      name.push_back('_');
    }
  }
  return name.substr(0, kLongestName);
}

/// The name, or one that continues it and is not among `names` yet; it is among them afterwards.
std::string unique_name(const std::string& name, std::set<std::string>& names) {
  std::string unique = name;
  for (int k = 2; !names.insert(unique).second; ++k) {
    std::string suffix = std::to_string(k);
    suffix.insert(suffix.begin(), '_');
    unique = name.substr(0, kLongestName - suffix.size()) + suffix;
  }
  return unique;
}

/// The numbers of one channel: a column for every element of every field.
class Columns {
 public:
  void add_message(int64_t utime, const std::vector<MessageLeaf>& leaves) {
    utime_.push_back(static_cast<double>(utime));
    for (const MessageLeaf& leaf : leaves) {
      if (leaf.kind == Kind::kString) {
        strings_.emplace(leaf.path, std::string(leaf.bytes.begin(), leaf.bytes.end()));
      } else if (leaf.kind != Kind::kByte || leaf.bytes.size() == 1) {
        // The last array index selects the column within the field.
        const size_t bracket = leaf.path.back() == ']' ? leaf.path.rfind('[') : std::string::npos;
        std::vector<double>& column = column_of(leaf.path.substr(0, bracket), leaf.path);
        column.resize(utime_.size() - 1, NAN);
        column.push_back(number_in(leaf));
      }
    }
  }

  /// The fields of the channel's struct. To be called once: moves the numbers.
  std::vector<MatField> take_fields() {
    std::vector<MatField> fields;
    std::set<std::string> names;
    const auto add = [&](const std::string& name, MatField field) {
      field.name = unique_name(identifier(name), names);
      field.rows = utime_.size();
      fields.push_back(std::move(field));
    };
    add("log_utime", {.name = "", .columns = {utime_}});
    for (auto& [name, columns] : fields_) add(name, {.name = "", .columns = std::move(columns)});
    for (auto& [name, text] : strings_) add(name, {.name = "", .text = text});
    return fields;
  }

 private:
  std::vector<double>& column_of(const std::string& field, const std::string& path) {
    const auto known = column_index_.find(path);
    if (known != column_index_.end()) return fields_[known->second.first].second[known->second.second];
    auto at = std::ranges::find(fields_, field, [](const auto& entry) { return entry.first; });
    if (at == fields_.end()) at = fields_.insert(at, {field, {}});
    at->second.emplace_back();
    column_index_[path] = {static_cast<size_t>(at - fields_.begin()), at->second.size() - 1};
    return at->second.back();
  }

  std::vector<double> utime_;
  std::vector<std::pair<std::string, std::vector<std::vector<double>>>> fields_;
  std::map<std::string, std::pair<size_t, size_t>> column_index_;
  std::map<std::string, std::string> strings_;
};

}  // namespace

int64_t export_mat(const std::string& log, const std::string& file, const ChannelPatterns& patterns) {
  LogReader reader(log);
  std::vector<std::string> channels;
  while (const auto event = reader.next()) {
    const bool known = MessageSchemas::project().of(event->data) != nullptr;
    if (!known || !matches_any(patterns, event->channel)) continue;
    if (std::ranges::find(channels, event->channel) == channels.end()) channels.emplace_back(event->channel);
  }
  MatWriter mat(file);
  std::set<std::string> names;
  int64_t written = 0;
  Progress progress;
  for (size_t i = 0; i < channels.size(); ++i) {
    Columns columns;
    reader.rewind();
    while (const auto event = reader.next()) {
      if (event->channel != channels[i]) continue;
      progress.show(
          (static_cast<double>(i) + static_cast<double>(reader.position()) / static_cast<double>(reader.size())) /
          static_cast<double>(channels.size()));
      const MessageSchema* schema = MessageSchemas::project().of(event->data);
      const auto leaves = schema ? leaves_of(*schema, event->data) : std::nullopt;
      if (!leaves) continue;
      columns.add_message(event->utime, *leaves);
      ++written;
    }
    std::string name = identifier("c" + channels[i]).substr(1);
    if (name.empty() || !std::isalpha(static_cast<unsigned char>(name[0]))) name = "channel_" + name;
    name = unique_name(name.substr(0, kLongestName), names);
    mat.write_struct(name, columns.take_fields());
  }
  mat.close();
  report_damage(log, reader);
  return written;
}

}  // namespace multireach
