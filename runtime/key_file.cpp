#include "runtime/key_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "runtime/files.hpp"

namespace multireach {
namespace {

constexpr std::string_view kBegin = "multireach-key-1:";
constexpr size_t kKeyDigits = 2 * MessageKey::kSize, kChecksumDigits = 8;

/// Finds mistakes of copying.
std::string checksum_of(std::string_view text) {
  std::array<uint8_t, crypto_generichash_BYTES_MIN> hash;
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const uint8_t*>(text.data()), text.size(), nullptr, 0);
  return fmt::format("{:02x}{:02x}{:02x}{:02x}", hash[0], hash[1], hash[2], hash[3]);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\r\n";
  const size_t begin = text.find_first_not_of(kSpaces);
  return begin == std::string_view::npos ? "" : text.substr(begin, text.find_last_not_of(kSpaces) + 1 - begin);
}

}  // namespace

std::string text_of(const MessageKey& key) {
  std::string text(kBegin);
  for (const uint8_t byte : key.bytes) text += fmt::format("{:02x}", byte);
  return text + ":" + checksum_of(text);
}

MessageKey key_in(std::string_view text, const std::string& source) {
  const std::string_view line = trimmed(text);
  if (!line.starts_with(kBegin))
    throw InputError(source + ": holds no key; expected one line that multireach-key made");
  const size_t before_checksum = kBegin.size() + kKeyDigits;
  const bool complete = line.size() == before_checksum + 1 + kChecksumDigits && line[before_checksum] == ':';
  MessageKey key;
  size_t read = 0;
  const std::string_view digits = line.substr(kBegin.size(), kKeyDigits);
  if (!complete || line.substr(before_checksum + 1) != checksum_of(line.substr(0, before_checksum)) ||
      sodium_hex2bin(key.bytes.data(), key.bytes.size(), digits.data(), digits.size(), nullptr, &read, nullptr) != 0 ||
      read != key.bytes.size()) {
    throw InputError(source + ": the key is damaged: its checksum does not match; copy the whole line again");
  }
  return key;
}

MessageKey read_key_file(const std::string& path) {
  size_t size = 0;
  const int file = open_regular_file(path, size);
  struct stat status {};
  const bool private_file = fstat(file, &status) == 0 && (status.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  ::close(file);
  if (!private_file)
    throw InputError(fmt::format("{0}: other users can access this key; to make it private:  chmod 600 {0}", path));
  return key_in(read_text_file(path), path);
}

void write_key_file(const std::string& path, const MessageKey& key) {
  const auto fail = [&](const std::string& action) {
    throw InputError(path + ": cannot be " + action + " (" + std::strerror(errno) + ")");
  };
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file < 0 && errno == EEXIST) throw InputError(path + ": exists already and is not replaced");
  if (file < 0) fail("created");
  const std::string line = text_of(key) + "\n";
  const bool written = ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size()) && fsync(file) == 0;
  const int error = errno;
  ::close(file);
  if (written) return;
  ::unlink(path.c_str());
  errno = error;
  fail("written");
}

}  // namespace multireach
