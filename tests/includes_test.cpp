// Every #include of the sources against the table of allowed dependencies in docs/architecture.md.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace multireach {
namespace {

namespace fs = std::filesystem;
using Table = std::map<std::string, std::set<std::string>>;  // folder -> folders that it may include

const fs::path kRoot = MULTIREACH_SOURCE_DIR;

std::vector<std::string> code_spans(const std::string& text) {
  static const std::regex span("`([^`]*)`");
  std::vector<std::string> spans;
  for (std::sregex_iterator match(text.begin(), text.end(), span), end; match != end; ++match)
    spans.push_back((*match)[1]);
  return spans;
}

Table allowed_dependencies() {
  std::ifstream page(kRoot / "docs/architecture.md");
  Table table;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("| folder |")) inside = true;
    if (line.empty()) inside = false;
    if (!inside || !line.starts_with("| `")) continue;
    std::vector<std::string> cells;
    std::stringstream row(line);
    for (std::string cell; std::getline(row, cell, '|');) cells.push_back(cell);
    const auto allowed = code_spans(cells.at(3));
    table[code_spans(cells.at(1)).at(0)] = {allowed.begin(), allowed.end()};
  }
  return table;
}

/// The row that a file belongs to: the longest folder of the table that holds it; "" for none.
std::string row_of(const Table& table, const fs::path& file) {
  for (fs::path folder = file.parent_path(); !folder.empty(); folder = folder.parent_path()) {
    if (table.contains(folder.string())) return folder.string();
  }
  return "";
}

bool allows(const Table& table, const std::string& from, const std::string& to) {
  if (from == to) return true;
  static const std::set<std::string> kOwnRows{"node", "sim", "drivers"};
  for (fs::path folder = to; !folder.empty(); folder = folder.parent_path()) {
    // The stage's own folder holds its parts together: it may include them all.
    if (table.at(from).contains(folder.string()) ||
        (folder.string() == from && !kOwnRows.contains(fs::path(to).filename().string())))
      return true;
    if (kOwnRows.contains(folder.filename().string())) return false;
  }
  return false;
}

/// One sentence for each include in `text` that the table does not allow.
std::vector<std::string> faults(const Table& table, const fs::path& file, std::istream& text) {
  static const std::regex include("\\s*#\\s*include\\s+\"([^\"]+)\"");
  const std::string from = row_of(table, file);
  std::vector<std::string> found;
  std::smatch match;
  for (std::string line; std::getline(text, line);) {
    if (!std::regex_search(line, match, include)) continue;
    const std::string to = row_of(table, match[1].str());
    if (to.empty() || !allows(table, from, to)) {
      found.push_back(file.string() + " includes " + match[1].str() + ", which its row '" + from + "' does not allow");
    }
  }
  return found;
}

TEST(Includes, FollowTheTableOfTheArchitecture) {
  const Table table = allowed_dependencies();
  ASSERT_GT(table.size(), 20U);
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot)) {
    const fs::path file = entry.path().lexically_relative(kRoot);
    if (file.extension() != ".cpp" && file.extension() != ".hpp") continue;
    if (row_of(table, file).empty()) continue;  // tests, bench, and what the build makes
    std::ifstream text(entry.path());
    for (const std::string& fault : faults(table, file, text)) ADD_FAILURE() << fault;
    ++files;
  }
  EXPECT_GT(files, 200);
}

TEST(Includes, AnArrowAgainstTheTableIsFound) {
  const Table table = allowed_dependencies();
  const auto refused = [&](const std::string& file, const std::string& included) {
    std::istringstream text("#include \"" + included + "\"\n");
    return faults(table, file, text).size() == 1;
  };
  EXPECT_TRUE(refused("controller/law/any.cpp", "runtime/config.hpp"));
  EXPECT_TRUE(refused("controller/law/any.cpp", "vision/track/any.hpp"));
  EXPECT_TRUE(refused("controller/ik/any.cpp", "controller/law/any.hpp"));
  EXPECT_TRUE(refused("controller/reach_controller.cpp", "controller/node/any.hpp"));
  EXPECT_TRUE(refused("runtime/any.cpp", "controller/law/any.hpp"));
  EXPECT_TRUE(refused("numeric/any.hpp", "kinematics/chain.hpp"));
  EXPECT_TRUE(refused("camera/rendering/any.cpp", "vision/node/any.hpp"));
  EXPECT_TRUE(refused("controller/any.hpp", "nowhere/any.hpp"));
  EXPECT_FALSE(refused("controller/law/any.cpp", "controller/ik/any.hpp"));
  EXPECT_FALSE(refused("tools/log/any.cpp", "runtime/config.hpp"));
  EXPECT_FALSE(refused("camera/node/any.cpp", "camera/devices/any.hpp"));
}

TEST(Includes, NoSourceOutsideTestsIsNamedAsATest) {
  const Table table = allowed_dependencies();
  for (const auto& entry : fs::recursive_directory_iterator(kRoot)) {
    const fs::path file = entry.path().lexically_relative(kRoot);
    if (row_of(table, file).empty() || file.extension() != ".cpp") continue;
    EXPECT_FALSE(file.stem().string().ends_with("_test")) << file;
  }
}

}  // namespace
}  // namespace multireach
