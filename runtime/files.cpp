#include "runtime/files.hpp"

#include <fcntl.h>
#include <glob.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "kinematics/urdf_chain.hpp"

namespace multireach {
namespace {

template <class Bytes>
Bytes read_file(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw InputError(path + ": is a folder, not a file");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path + ": cannot be opened (" + std::strerror(errno) + ")");
  Bytes bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw InputError(path + ": cannot be read (" + std::strerror(errno) + ")");
  return bytes;
}

}  // namespace

std::string read_text_file(const std::string& path) {
  return read_file<std::string>(path);
}
std::vector<uint8_t> read_binary_file(const std::string& path) {
  return read_file<std::vector<uint8_t>>(path);
}

void write_text_file(const std::string& path, const std::string& text) {
  if (path == "-") {
    std::cout << text << std::flush;
    if (!std::cout) throw InputError("standard output: cannot be written");
    return;
  }
  OutputFile file(path);
  file.write({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  file.finish();
}

OutputFile::OutputFile(const std::string& path) : path_(path) {
  // Devices and pipes have no old content to keep, so they are opened directly.
  std::error_code error;
  const bool replace = !std::filesystem::exists(path, error) || std::filesystem::is_regular_file(path, error);
  if (replace) partial_ = path + ".partial." + std::to_string(getpid());
  file_ = open((replace ? partial_ : path).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) fail();
}

OutputFile::~OutputFile() {
  if (file_ >= 0) ::close(file_);
  if (!partial_.empty()) std::remove(partial_.c_str());
}

void OutputFile::fail() const {
  throw InputError(path_ + ": cannot be written (" + std::strerror(errno) + ")");
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
  partial_.clear();
}

void write_json_file(const std::string& path, const nlohmann::json& json) {
  write_text_file(path, json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
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
