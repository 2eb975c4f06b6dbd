#include "tools/log/mat_writer.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace multireach {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they are in memory");

/// Data types and array classes of the format.
constexpr uint32_t kInt8 = 1, kUint16 = 4, kInt32 = 5, kUint32 = 6, kDouble = 9, kMatrix = 14;
constexpr uint32_t kStructClass = 2, kCharClass = 4, kDoubleClass = 6;

constexpr size_t kTag = 8;          // bytes: type and size
constexpr size_t kNameLength = 64;  // bytes of a field's name with its terminating zero
constexpr size_t kBuffer = 1 << 18;
constexpr size_t kHeaderText = 124;  // bytes, with 8 for a subsystem that there is not

size_t padded(size_t size) {
  return (size + 7) / 8 * 8;
}

/// The size of what every array begins with: flags, dimensions and name.
size_t begin_size(const std::string& name) {
  return kTag + 8 + kTag + 8 + kTag + padded(name.size());
}

size_t content_size(const MatField& field) {
  const size_t data = field.columns.empty() ? 2 * field.text.size() : 8 * field.rows * field.columns.size();
  return begin_size("") + kTag + padded(data);
}

}  // namespace

MatWriter::MatWriter(const std::string& path) : path_(path), file_(path) {
  std::string text = "MATLAB 5.0 MAT-file, written by multireach-log";
  text.resize(kHeaderText, ' ');
  put(text);
  put_number(uint16_t{0x0100});
  put("IM");  // read as "MI" on a machine of the other byte order
}

void MatWriter::put(std::string_view bytes) {
  waiting_ += bytes;
  if (waiting_.size() > kBuffer) flush();
}

void MatWriter::flush() {
  file_.write({reinterpret_cast<const uint8_t*>(waiting_.data()), waiting_.size()});
  waiting_.clear();
}

template <class Number>
void MatWriter::put_number(Number value) {
  put({reinterpret_cast<const char*>(&value), sizeof value});
}

void MatWriter::put_padding(size_t size) {
  put(std::string(padded(size) - size, '\0'));
}

void MatWriter::put_element(uint32_t type, std::string_view data) {
  put_number(type);
  put_number(static_cast<uint32_t>(data.size()));
  put(data);
  put_padding(data.size());
}

void MatWriter::begin_matrix(size_t size, uint32_t array_class, size_t rows, size_t columns, const std::string& name) {
  if (size > std::numeric_limits<uint32_t>::max() || rows > std::numeric_limits<int32_t>::max()) {
    throw InputError(path_ + ": more than 4 GB of numbers in one channel, which the format cannot hold; cut the log");
  }
  put_number(kMatrix);
  put_number(static_cast<uint32_t>(size));
  put_number(kUint32);
  put_number(uint32_t{8});
  put_number(array_class);
  put_number(uint32_t{0});
  put_number(kInt32);
  put_number(uint32_t{8});
  put_number(static_cast<int32_t>(rows));
  put_number(static_cast<int32_t>(columns));
  put_element(kInt8, name);
}

void MatWriter::put_field(const MatField& field) {
  const size_t size = content_size(field);
  if (field.columns.empty()) {
    begin_matrix(size, kCharClass, 1, field.text.size(), "");
    put_number(kUint16);
    put_number(static_cast<uint32_t>(2 * field.text.size()));
    for (const char c : field.text) put_number(static_cast<uint16_t>(static_cast<unsigned char>(c)));
    put_padding(2 * field.text.size());
    return;
  }
  begin_matrix(size, kDoubleClass, field.rows, field.columns.size(), "");
  put_number(kDouble);
  put_number(static_cast<uint32_t>(8 * field.rows * field.columns.size()));
  for (const std::vector<double>& column : field.columns) {
    for (size_t row = 0; row < field.rows; ++row) put_number(row < column.size() ? column[row] : NAN);
  }
}

void MatWriter::write_struct(const std::string& name, const std::vector<MatField>& fields) {
  size_t size = begin_size(name) + kTag + kTag + kNameLength * fields.size();
  for (const MatField& field : fields) size += kTag + content_size(field);
  begin_matrix(size, kStructClass, 1, 1, name);
  // A small element: the size is in the upper half of the type.
  put_number(kInt32 | uint32_t{4} << 16);
  put_number(static_cast<int32_t>(kNameLength));
  std::string names;
  for (const MatField& field : fields) {
    names += field.name;
    names.resize((names.size() / kNameLength + 1) * kNameLength, '\0');
  }
  put_element(kInt8, names);
  for (const MatField& field : fields) put_field(field);
}

void MatWriter::close() {
  flush();
  file_.finish();
}

}  // namespace multireach
