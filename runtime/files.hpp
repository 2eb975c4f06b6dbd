#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "kinematics/chain.hpp"

namespace multireach {

/// Wrong usage or input: one sentence that a user can act on. Programs print it and exit with 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The whole file as text or bytes. Throws InputError that names the file and what is wrong with it.
std::string read_text_file(const std::string& path);
std::vector<uint8_t> read_binary_file(const std::string& path);

/// A file that is written piece by piece and takes the old one's place only when finished; what was begun and not
/// finished is removed. Devices and pipes are written as they are. All throw InputError when it cannot be written.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::span<const uint8_t> bytes);
  void finish();

 private:
  [[noreturn]] void fail() const;

  std::string path_, partial_;
  int file_ = -1;
};

/// Writes the whole text, or leaves what was there: a new file takes the old one's place only when complete. "-" is
/// standard output. Throws InputError when it cannot be written, as on a full disk.
void write_text_file(const std::string& path, const std::string& text);
/// The same with JSON, indented.
void write_json_file(const std::string& path, const nlohmann::json& json);

/// The chain between two links of a URDF file. Throws InputError that names the file.
Chain load_chain(const std::string& urdf_path, const std::string& base, const std::string& tip);

/// The files that `pattern` names, in the order of their names: a file, all files of a folder, or a pattern with * and
/// ?. Throws InputError that names `option`, by which the pattern came, when there is none.
std::vector<std::string> matching_files(const std::string& option, const std::string& pattern);

/// `path` as it is when absolute, else as seen from the folder of `file`.
std::string beside(const std::string& file, const std::string& path);

}  // namespace multireach
