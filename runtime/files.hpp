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

/// A file or standard output could not be written completely, e.g. on a full disk. Programs print it and exit with
/// code 1.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

constexpr size_t kMaxTextFile = size_t{16} << 20;   ///< bytes: configuration, URDF, tables of calibration samples
constexpr size_t kMaxBinaryFile = size_t{1} << 30;  ///< bytes: an image

/// The whole file as text or bytes. Throws InputError that names the file and what is wrong with it. Only regular files
/// are read, and none that is larger than the bound above: a device or a pipe may never end.
std::string read_text_file(const std::string& path);
std::vector<uint8_t> read_binary_file(const std::string& path);
/// Opens a regular file for reading; never blocks. Returns its descriptor, and its size in bytes. Throws InputError.
int open_regular_file(const std::string& path, size_t& size);

/// Writes a file in pieces under a temporary name. `finish` replaces the old file; without it, or when SIGINT, SIGTERM
/// or SIGHUP ends the program, the temporary file is removed and the old file stays. Devices and pipes are written
/// directly. Throws InputError when the file cannot be opened, and OutputError when writing fails later.
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
  void forget_partial();

  std::string path_, partial_;
  int file_ = -1;
  size_t slot_;  // of the temporary file, among those that a signal removes
};

/// Writes the whole text or leaves the old file unchanged: the new file replaces it only when complete. "-" is standard
/// output. Throws as OutputFile does.
void write_text_file(const std::string& path, const std::string& text);
/// Writes indented JSON, like `write_text_file`.
void write_json_file(const std::string& path, const nlohmann::json& json);
/// Flushes standard output. Throws OutputError when anything that was printed could not be written.
void flush_standard_output();

/// Checks, before long work begins, whether its results can be written to these files: refuses those that cannot be
/// opened, and a file that is named twice. Empty names are ignored; "-" is standard output. Throws InputError.
void check_outputs(const std::vector<std::string>& paths);

/// The kinematic chain between two links of a URDF file. Throws InputError that names the file.
Chain load_chain(const std::string& urdf_path, const std::string& base, const std::string& tip);

/// The files that match `pattern`, sorted by name. `pattern` is a file, a folder (all its files), or a pattern with *
/// and ?. Throws InputError that names `option` when no file matches.
std::vector<std::string> matching_files(const std::string& option, const std::string& pattern);

/// Resolves a relative `path` against the folder of `file`; an absolute path is returned unchanged.
std::string resolve_relative(const std::string& file, const std::string& path);

}  // namespace multireach
