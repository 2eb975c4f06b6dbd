// Images in files: a folder with pairs.csv, and the layout of the EuRoC MAV dataset.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>

#include "runtime/files.hpp"
#include "runtime/image_file.hpp"
#include "tools/log/import/image_source.hpp"
#include "tools/log/import/image_store.hpp"

namespace multireach {
namespace {

constexpr const char* kPairsTable = "pairs.csv";
constexpr const char* kPairsHeader = "time_s,left,right";
constexpr const char* kPairsHeaderWithBoth = "time_s,left,right,right_time_s";
constexpr const char* kEurocHeader = "#timestamp [ns],filename";

/// A text file of lines with fields between commas; errors name file and line.
class Table {
 public:
  explicit Table(const std::string& path) : path_(path), text_(read_text_file(path)) {}

  /// The next line that is not empty, without spaces around the fields; nothing at the end.
  std::optional<std::vector<std::string>> next() {
    while (at_ < text_.size()) {
      const size_t end = std::min(text_.find('\n', at_), text_.size());
      std::string line = text_.substr(at_, end - at_);
      at_ = end + 1;
      ++number_;
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      std::vector<std::string> fields;
      for (size_t begin = 0; begin <= line.size();) {
        const size_t comma = std::min(line.find(',', begin), line.size());
        const std::string field = line.substr(begin, comma - begin);
        const size_t first = field.find_first_not_of(" \t\r");
        fields.push_back(first == std::string::npos ? std::string()
                                                    : field.substr(first, field.find_last_not_of(" \t\r") + 1 - first));
        begin = comma + 1;
      }
      return fields;
    }
    return std::nullopt;
  }
  [[noreturn]] void fail(const std::string& sentence) const {
    throw InputError(fmt::format("{}:{}: {}", path_, number_, sentence));
  }

 private:
  std::string path_, text_;
  size_t at_ = 0;
  int64_t number_ = 0;
};

/// Seconds with a decimal point as whole microseconds, without rounding through binary fractions: further digits are
/// cut off. Nothing for anything else.
std::optional<int64_t> microseconds_of(const std::string& text) {
  const size_t point = std::min(text.find('.'), text.size());
  const std::string fraction = point < text.size() ? text.substr(point + 1) : "";
  const std::string digits = text.substr(0, point) + (fraction + "000000").substr(0, 6);
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (point == 0 || !std::ranges::all_of(fraction, is_digit) || !is_digit(text[0])) return std::nullopt;
  int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

/// Images that are files.
class FilesSource : public ImageSource {
 public:
  explicit FilesSource(const ImportOptions& options) : store_(options.jpeg_quality) {}
  std::vector<ListedImage> list(const Progress& progress) override {
    progress(1);
    return images_;
  }
  Frame read(const ListedImage& image) override {
    const std::string& path = files_[image.number];
    return store_.file_frame(read_binary_file(path), path, image.utime);
  }

 protected:
  void add(Side side, int64_t utime, const std::string& file) {
    images_.push_back({utime, side, files_.size()});
    files_.push_back(file);
  }

 private:
  ImageStore store_;
  std::vector<ListedImage> images_;
  std::vector<std::string> files_;
};

/// FOLDER/pairs.csv: the time in seconds and the names of the two files, relative to the folder.
class PairsFolder : public FilesSource {
 public:
  explicit PairsFolder(const ImportOptions& options) : FilesSource(options) {
    const std::string path = options.input + "/" + kPairsTable;
    Table table(path);
    const std::vector<std::string> header = table.next().value_or(std::vector<std::string>{});
    std::string words;
    for (const std::string& field : header) words += (words.empty() ? "" : ",") + field;
    if (words != kPairsHeader && words != kPairsHeaderWithBoth)
      table.fail(fmt::format("'{}' are not the names of the columns; expected {} or {}", words, kPairsHeader,
                             kPairsHeaderWithBoth));
    std::array<std::optional<int64_t>, 2> before;
    while (const auto fields = table.next()) {
      if (fields->size() != header.size())
        table.fail(fmt::format("has {} values; expected {}: {}", fields->size(), header.size(), words));
      for (const Side side : {Side::kLeft, Side::kRight}) {
        const std::string& time = (*fields)[side == Side::kRight && header.size() == 4 ? 3 : 0];
        const std::string& file = (*fields)[1 + index(side)];
        const auto utime = microseconds_of(time);
        if (!utime) table.fail("'" + time + "' is not a time; expected seconds, as 12.345678");
        if (before[index(side)] && *utime <= *before[index(side)])
          table.fail("the time " + time + " is not after that of the line before; expected growing times");
        if (file.empty()) table.fail("a file has no name");
        before[index(side)] = utime;
        add(side, *utime, resolve_relative(path, file));
      }
    }
  }
};

/// FOLDER/mav0/cam0/data.csv, or FOLDER/cam0/data.csv: the time in nanoseconds and the name of the file in cam0/data.
class EurocFolder : public FilesSource {
 public:
  explicit EurocFolder(const ImportOptions& options) : FilesSource(options) {
    std::error_code error;
    const std::string inside = options.input + "/mav0";
    const std::string root = std::filesystem::is_directory(inside, error) ? inside : options.input;
    add_camera(root + "/" + (options.left.empty() ? "cam0" : options.left), Side::kLeft);
    add_camera(root + "/" + (options.right.empty() ? "cam1" : options.right), Side::kRight);
  }

 private:
  void add_camera(const std::string& folder, Side side) {
    Table table(folder + "/data.csv");
    if (table.next() != std::vector<std::string>{"#timestamp [ns]", "filename"})
      table.fail(fmt::format("are not the names of the columns of an EuRoC recording; expected {}", kEurocHeader));
    int64_t before = -1;
    while (const auto fields = table.next()) {
      int64_t ns = -1;
      const std::string& time = fields->front();
      const auto [end, fault] = std::from_chars(time.data(), time.data() + time.size(), ns);
      if (fault != std::errc() || end != time.data() + time.size() || ns < 0)
        table.fail("'" + time + "' is not a time; expected nanoseconds");
      if (fields->size() != 2 || (*fields)[1].empty()) table.fail("expected a time and the name of a file");
      if (ns / 1000 <= before) table.fail("the time " + time + " is not after that of the line before");
      before = ns / 1000;
      add(side, before, folder + "/data/" + (*fields)[1]);
    }
  }
};

}  // namespace

std::unique_ptr<ImageSource> open_pairs_folder(const ImportOptions& options) {
  return std::make_unique<PairsFolder>(options);
}

std::unique_ptr<ImageSource> open_euroc_folder(const ImportOptions& options) {
  return std::make_unique<EurocFolder>(options);
}

}  // namespace multireach
