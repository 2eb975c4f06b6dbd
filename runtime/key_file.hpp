#pragma once

#include <string>
#include <string_view>

#include "runtime/tagged_message.hpp"

namespace multireach {

/// A key as one line of text, without the end of the line: "multireach-key-1:", the key, ":" and a checksum, both
/// hexadecimal.
std::string text_of(const MessageKey& key);
/// The key in such a line, with spaces around it. Throws InputError that names `source`.
MessageKey key_in(std::string_view text, const std::string& source);

/// Reads a key file, which holds one such line. Throws InputError; also when the file's permissions let others read or
/// change it.
MessageKey read_key_file(const std::string& path);
/// Writes a key file that only its owner can read. Throws InputError when the file exists or cannot be written.
void write_key_file(const std::string& path, const MessageKey& key);

}  // namespace multireach
