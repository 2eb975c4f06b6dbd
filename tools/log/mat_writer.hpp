#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/files.hpp"

namespace multireach {

/// One field of a MATLAB struct: a matrix of doubles, or a text.
struct MatField {
  std::string name;  ///< letters, digits and underscores, at most 63
  size_t rows = 0;
  std::vector<std::vector<double>> columns{};  ///< shorter ones are filled up with NaN
  std::string text{};                          ///< where there are no columns
};

/// Writes a MATLAB file of version 5 (MathWorks, "MAT-File Format"), uncompressed, as a stream. Throws as OutputFile
/// does, and InputError when a variable is larger than the format allows (4 GB).
class MatWriter {
 public:
  explicit MatWriter(const std::string& path);
  void write_struct(const std::string& name, const std::vector<MatField>& fields);
  void close();

 private:
  void put(std::string_view bytes);
  template <class Number>
  void put_number(Number value);
  void put_padding(size_t size);
  void put_element(uint32_t type, std::string_view data);
  void begin_matrix(size_t size, uint32_t array_class, size_t rows, size_t columns, const std::string& name);
  void put_field(const MatField& field);
  void flush();

  std::string path_;
  OutputFile file_;
  std::string waiting_;
};

}  // namespace multireach
