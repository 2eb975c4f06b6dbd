#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace multireach {

/// A table of numbers with named columns, for a plot, as CSV.
class Table {
 public:
  explicit Table(const std::vector<std::string>& columns) {
    for (const std::string& column : columns) text_ += (text_.empty() ? "" : ",") + column;
    text_ += '\n';
  }
  void row(const std::vector<double>& values) {
    char number[32];
    for (size_t i = 0; i < values.size(); ++i) {
      std::snprintf(number, sizeof number, "%s%.9g", i == 0 ? "" : ",", values[i]);
      text_ += number;
    }
    text_ += '\n';
  }
  const std::string& csv() const { return text_; }

 private:
  std::string text_;
};

}  // namespace multireach
