#include "runtime/files.hpp"

#include <fcntl.h>
#include <glob.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>

#include "kinematics/urdf_chain.hpp"

namespace multireach {
namespace {

constexpr size_t kMaxOpenOutputs = 256;  // further ones are not removed by a signal
constexpr std::array kEndingSignals{SIGINT, SIGTERM, SIGHUP};

/// Names of the temporary files that exist now, for the signal handler, which may only use atomic variables.
std::array<std::atomic<const char*>, kMaxOpenOutputs> partial_files{};

void remove_partial_files(int signal_number) {
  for (std::atomic<const char*>& name : partial_files) {
    if (const char* path = name.load()) unlink(path);
  }
  // The handler was installed for one signal: the next one has the default action again.
  raise(signal_number);
}

/// A program that handles a signal itself, or ignores it, keeps doing so.
void remove_partial_files_on_signals() {
  for (const int number : kEndingSignals) {
    struct sigaction current = {};
    if (sigaction(number, nullptr, &current) != 0 || current.sa_handler != SIG_DFL) continue;
    struct sigaction action = {};
    action.sa_handler = remove_partial_files;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(number, &action, nullptr);
  }
}

size_t remember_partial(const char* path) {
  for (size_t slot = 0; slot < kMaxOpenOutputs; ++slot) {
    const char* free = nullptr;
    if (partial_files[slot].compare_exchange_strong(free, path)) return slot;
  }
  return kMaxOpenOutputs;
}

std::string megabytes(size_t bytes) {
  return std::to_string((bytes + (size_t{1} << 20) - 1) >> 20) + " MB";
}

template <class Bytes>
Bytes read_file(const std::string& path, size_t max_size) {
  size_t size = 0;
  const int file = open_regular_file(path, size);
  Bytes bytes;
  ssize_t got = size <= max_size ? 1 : 0;
  size_t filled = 0;
  // Files of the kernel have size 0 and content, so the file is read to its end.
  for (bytes.resize(std::min(size, max_size) + 1); got != 0 && filled <= max_size; filled += static_cast<size_t>(got)) {
    if (filled == bytes.size()) bytes.resize(std::min(2 * filled, max_size + 1));
    do {
      got = ::read(file, bytes.data() + filled, bytes.size() - filled);
    } while (got < 0 && errno == EINTR);
    if (got < 0) break;
  }
  const int error = errno;
  ::close(file);
  if (got < 0) throw InputError(path + ": cannot be read (" + std::strerror(error) + ")");
  if (std::max(filled, size) > max_size) {
    throw InputError(path + ": has " + megabytes(std::max(filled, size)) + "; at most " + megabytes(max_size) +
                     " are read");
  }
  bytes.resize(filled);
  return bytes;
}

}  // namespace

int open_regular_file(const std::string& path, size_t& size) {
  // O_NONBLOCK: opening a pipe would wait for its other end.
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (file < 0) throw InputError(path + ": cannot be opened (" + std::strerror(errno) + ")");
  struct stat status = {};
  const bool known = fstat(file, &status) == 0;
  if (known && S_ISREG(status.st_mode)) {
    size = static_cast<size_t>(status.st_size);
    return file;
  }
  ::close(file);
  if (known && S_ISDIR(status.st_mode)) throw InputError(path + ": is a folder, not a file");
  throw InputError(path + ": is a device or a pipe; a regular file is expected");
}

std::string read_text_file(const std::string& path) {
  return read_file<std::string>(path, kMaxTextFile);
}
std::vector<uint8_t> read_binary_file(const std::string& path) {
  return read_file<std::vector<uint8_t>>(path, kMaxBinaryFile);
}

void write_text_file(const std::string& path, const std::string& text) {
  if (path == "-") {
    std::cout << text;
    flush_standard_output();
    return;
  }
  OutputFile file(path);
  file.write({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  file.finish();
}

void flush_standard_output() {
  errno = 0;
  std::cout.flush();
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::cout && std::ferror(stdout) == 0) return;
  throw OutputError(std::string("standard output: cannot be written") +
                    (errno != 0 ? std::string(" (") + std::strerror(errno) + ")" : ""));
}

OutputFile::OutputFile(const std::string& path) : path_(path), slot_(kMaxOpenOutputs) {
  // Devices and pipes have no old content to keep, so they are opened directly.
  std::error_code error;
  const bool replace = !std::filesystem::exists(path, error) || std::filesystem::is_regular_file(path, error);
  if (replace) {
    remove_partial_files_on_signals();
    partial_ = path + ".partial." + std::to_string(getpid());
    slot_ = remember_partial(partial_.c_str());
  }
  file_ = open((replace ? partial_ : path).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ >= 0) return;
  const int reason = errno;
  forget_partial();
  const std::string sentence = path_ + ": cannot be written (" + std::strerror(reason) + ")";
  if (reason == ENOSPC || reason == EDQUOT) throw OutputError(sentence);
  throw InputError(sentence);
}

OutputFile::~OutputFile() {
  if (file_ >= 0) ::close(file_);
  if (!partial_.empty()) unlink(partial_.c_str());
  forget_partial();
}

void OutputFile::forget_partial() {
  if (slot_ < kMaxOpenOutputs) partial_files[slot_] = nullptr;
  slot_ = kMaxOpenOutputs;
  partial_.clear();
}

void OutputFile::fail() const {
  throw OutputError(path_ + ": cannot be written (" + std::strerror(errno) + ")");
}

void OutputFile::write(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail();
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
}

void OutputFile::finish() {
  const int closed = ::close(file_);
  file_ = -1;
  if (closed != 0) fail();
  if (!partial_.empty() && std::rename(partial_.c_str(), path_.c_str()) != 0) fail();
  forget_partial();
}

void write_json_file(const std::string& path, const nlohmann::json& json) {
  write_text_file(path, json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

void check_outputs(const std::vector<std::string>& paths) {
  std::set<std::string> seen;
  for (const std::string& path : paths) {
    if (path.empty() || path.starts_with("/dev/")) continue;
    if (!seen.insert(path).second) throw InputError("'" + path + "' is named for two outputs; expected one each");
    if (path != "-") OutputFile probe(path);
  }
}

Chain load_chain(const std::string& urdf_path, const std::string& base, const std::string& tip) {
  const std::string xml = read_text_file(urdf_path);
  try {
    return chain_from_urdf(xml, base, tip);
  } catch (const std::invalid_argument& fault) {
    throw InputError(urdf_path + ": " + fault.what());
  }
}

std::vector<std::string> matching_files(const std::string& option, const std::string& pattern) {
  std::vector<std::string> files;
  std::error_code error;
  if (std::filesystem::is_directory(pattern, error)) {
    for (const auto& entry : std::filesystem::directory_iterator(pattern)) {
      if (entry.is_regular_file()) files.push_back(entry.path().string());
    }
    std::ranges::sort(files);
  } else {
    glob_t found = {};
    if (glob(pattern.c_str(), 0, nullptr, &found) == 0) files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
    globfree(&found);
  }
  if (files.empty()) throw InputError(option + ": no file matches '" + pattern + "'");
  return files;
}

std::string resolve_relative(const std::string& file, const std::string& path) {
  return (std::filesystem::path(file).parent_path() / path).string();
}

}  // namespace multireach
