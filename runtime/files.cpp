#include "runtime/files.hpp"

#include <unistd.h>

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
  // A device or a pipe has no old content to keep.
  std::error_code error;
  const bool replace = !std::filesystem::exists(path, error) || std::filesystem::is_regular_file(path, error);
  const std::string partial = replace ? path + ".partial." + std::to_string(getpid()) : path;
  errno = 0;
  std::ofstream out(partial, std::ios::binary);
  out << text;
  out.close();
  if (!out) {
    const std::string reason = errno ? std::strerror(errno) : "write failed";
    if (replace) std::remove(partial.c_str());
    throw InputError(path + ": cannot be written (" + reason + ")");
  }
  if (replace && std::rename(partial.c_str(), path.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    std::remove(partial.c_str());
    throw InputError(path + ": cannot be written (" + reason + ")");
  }
}

void write_json_file(const std::string& path, const nlohmann::json& json) {
  write_text_file(path, json.dump(2) + "\n");
}

Chain load_chain(const std::string& urdf_path, const std::string& base, const std::string& tip) {
  const std::string xml = read_text_file(urdf_path);
  try {
    return chain_from_urdf(xml, base, tip);
  } catch (const std::invalid_argument& fault) {
    throw InputError(urdf_path + ": " + fault.what());
  }
}

std::string beside(const std::string& file, const std::string& path) {
  return (std::filesystem::path(file).parent_path() / path).string();
}

}  // namespace multireach
