#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <unordered_map>

#include "runtime/log_file.hpp"
#include "runtime/message_schema.hpp"
#include "runtime/progress.hpp"
#include "tools/log/export.hpp"
#include "tools/log/log_edit.hpp"

namespace multireach {

bool matches_any(const ChannelPatterns& patterns, std::string_view channel) {
  const std::string name(channel);
  return patterns.empty() || std::ranges::any_of(patterns, [&](const std::string& pattern) {
           return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
         });
}

std::string safe_file_name(std::string_view name) {
  std::string result(name);
  for (char& c : result) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    if (!plain) c = '_';
  }
  return result;
}

namespace {

constexpr size_t kBuffer = 1 << 16;

/// The table of one channel. Its columns are the values of all its messages, in the order of first appearance.
class Table {
 public:
  void add_columns(const std::vector<MessageLeaf>& leaves) {
    for (const MessageLeaf& leaf : leaves) {
      if (leaf.kind == MessageSchema::Kind::kByte && leaf.bytes.size() != 1) continue;
      if (columns_.emplace(leaf.path, names_.size()).second) names_.push_back(leaf.path);
    }
  }

  void open(const std::string& path) {
    file_ = std::make_unique<OutputFile>(path);
    text_ = "log_utime";
    for (const std::string& name : names_) text_ += "," + name;
    text_ += "\n";
  }

  void write(int64_t utime, const std::vector<MessageLeaf>& leaves) {
    std::vector<std::string> row(names_.size());
    for (const MessageLeaf& leaf : leaves) {
      if (const auto column = columns_.find(leaf.path); column != columns_.end()) row[column->second] = cell(leaf);
    }
    text_ += std::to_string(utime);
    for (const std::string& value : row) text_ += "," + value;
    text_ += "\n";
    if (text_.size() > kBuffer) flush();
  }

  void close() {
    flush();
    file_->finish();
  }

 private:
  static std::string cell(const MessageLeaf& leaf) {
    if (leaf.kind != MessageSchema::Kind::kString) return leaf.text();
    std::string quoted = "\"";
    for (const uint8_t c : leaf.bytes) {
      quoted.push_back(static_cast<char>(c));
      if (c == '"') quoted.push_back('"');
    }
    quoted.push_back('"');
    return quoted;
  }
  void flush() {
    file_->write({reinterpret_cast<const uint8_t*>(text_.data()), text_.size()});
    text_.clear();
  }

  std::unordered_map<std::string, size_t> columns_;
  std::vector<std::string> names_;
  std::unique_ptr<OutputFile> file_;
  std::string text_;
};

}  // namespace

int64_t export_csv(const std::string& log, const std::string& folder, const ChannelPatterns& patterns) {
  LogReader reader(log);
  std::map<std::string, Table, std::less<>> tables;
  Progress progress;
  const auto each = [&](double from, const auto& visit) {
    reader.rewind();
    while (const auto event = reader.next()) {
      progress.show(from + 0.5 * static_cast<double>(reader.position()) / static_cast<double>(reader.size()));
      const MessageSchema* schema = MessageSchemas::project().of(event->data);
      if (!schema || !matches_any(patterns, event->channel)) continue;
      if (const auto leaves = leaves_of(*schema, event->data)) visit(*event, *leaves);
    }
  };
  each(0, [&](const LogEvent& event, const std::vector<MessageLeaf>& leaves) {
    tables[std::string(event.channel)].add_columns(leaves);
  });
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  std::set<std::string> names;
  for (auto& [channel, table] : tables) {
    std::string name = safe_file_name(channel);
    while (!names.insert(name).second) name += '_';
    table.open(folder + "/" + name + ".csv");
  }
  int64_t written = 0;
  each(0.5, [&](const LogEvent& event, const std::vector<MessageLeaf>& leaves) {
    tables.find(event.channel)->second.write(event.utime, leaves);
    ++written;
  });
  for (auto& [channel, table] : tables) table.close();
  report_damage(log, reader);
  return written;
}

}  // namespace multireach
