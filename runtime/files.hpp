#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "kinematics/chain.hpp"

namespace multireach {

/// Wrong usage or input, explained in one sentence that a user can act on. Programs print it and exit with code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The whole file as text or bytes. Throws InputError that names the file and what is wrong with it.
std::string read_text_file(const std::string& path);
std::vector<uint8_t> read_binary_file(const std::string& path);

/// Writes a file in pieces under a temporary name. `finish` replaces the old file; without it the temporary file is
/// removed and the old file stays. Devices and pipes are written directly. All members throw InputError when writing
/// fails.
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

/// Writes the whole text or leaves the old file unchanged: the new file replaces it only when complete. "-" is standard
/// output. Throws InputError when it cannot be written, e.g. on a full disk.
void write_text_file(const std::string& path, const std::string& text);
/// Writes indented JSON, like `write_text_file`.
void write_json_file(const std::string& path, const nlohmann::json& json);

/// The kinematic chain between two links of a URDF file. Throws InputError that names the file.
Chain load_chain(const std::string& urdf_path, const std::string& base, const std::string& tip);

/// The files that match `pattern`, sorted by name. `pattern` is a file, a folder (all its files), or a pattern with *
/// and ?. Throws InputError that names `option` when no file matches.
std::vector<std::string> matching_files(const std::string& option, const std::string& pattern);

/// Resolves a relative `path` against the folder of `file`; an absolute path is returned unchanged.
std::string resolve_relative(const std::string& file, const std::string& path);

}  // namespace multireach
