#include <matio.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <set>

#include "runtime/log_file.hpp"
#include "runtime/message_schema.hpp"
#include "runtime/message_walk.hpp"
#include "runtime/progress.hpp"
#include "tools/log/export.hpp"
#include "tools/log/log_edit.hpp"

namespace multireach {
namespace {

using Kind = MessageSchema::Kind;
using Matrix = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

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
  constexpr size_t kLongest = 63;
  return name.substr(0, kLongest);
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

  Matrix structure(const std::string& variable) {
    size_t dimensions[2] = {1, 1};
    Matrix result(Mat_VarCreateStruct(variable.c_str(), 2, dimensions, nullptr, 0), &Mat_VarFree);
    add(*result, "log_utime", {utime_});
    for (const auto& [name, columns] : fields_) add(*result, name, columns);
    for (auto& [name, text] : strings_) {
      size_t size[2] = {1, text.size()};
      put(*result, name, Mat_VarCreate(nullptr, MAT_C_CHAR, MAT_T_UINT8, 2, size, text.data(), 0));
    }
    return result;
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

  void add(matvar_t& structure, const std::string& name, const std::vector<std::vector<double>>& columns) const {
    std::vector<double> numbers;
    for (const std::vector<double>& column : columns) {
      numbers.insert(numbers.end(), column.begin(), column.end());
      numbers.insert(numbers.end(), utime_.size() - column.size(), NAN);
    }
    size_t size[2] = {utime_.size(), columns.size()};
    put(structure, name, Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size, numbers.data(), 0));
  }

  static void put(matvar_t& structure, const std::string& name, matvar_t* value) {
    const std::string field = identifier(name);
    Mat_VarAddStructField(&structure, field.c_str());
    Mat_VarSetStructFieldByName(&structure, field.c_str(), 0, value);
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
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) {
    throw InputError(file + ": exists and is not a regular file");
  }
  // The library writes to a file name only, so an incomplete file is written under another name and removed on failure.
  const std::string partial = file + ".partial." + std::to_string(getpid());
  struct Remover {
    const std::string& path;
    ~Remover() { std::remove(path.c_str()); }
  } const remover{partial};
  mat_t* mat = Mat_CreateVer(partial.c_str(), nullptr, MAT_FT_MAT5);
  if (!mat) throw InputError(file + ": cannot be written");
  std::unique_ptr<mat_t, decltype(&Mat_Close)> closer(mat, &Mat_Close);
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
    while (!names.insert(name).second) name += "_";
    if (Mat_VarWrite(mat, columns.structure(name).get(), MAT_COMPRESSION_NONE) != 0) {
      throw InputError(file + ": cannot be written");
    }
  }
  if (Mat_Close(closer.release()) != 0) throw InputError(file + ": cannot be written");
  if (std::rename(partial.c_str(), file.c_str()) != 0) throw InputError(file + ": cannot be written");
  report_damage(log, reader);
  return written;
}

}  // namespace multireach
