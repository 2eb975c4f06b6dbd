#include "kinematics/urdf_document.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <string>

namespace multireach {
namespace {

constexpr size_t kMaxText = size_t{16} << 20;  // bytes
constexpr int kMaxDepth = 64;                  // nested elements; a URDF has 6, with extensions some 12
constexpr int kMaxLinks = 2000;                // a humanoid with two hands has some 150

/// The position after the next `mark`; the end of the text when there is none.
size_t after(std::string_view text, std::string_view mark, size_t from) {
  const size_t found = text.find(mark, from);
  return found == std::string_view::npos ? text.size() : found + mark.size();
}

/// The position after the `>` that ends a tag. One inside a quoted value does not.
size_t after_tag(std::string_view text, size_t at) {
  char quote = 0;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return at + 1;
    }
  }
  return at;
}

/// Whether elements are nested more than kMaxDepth deep. Linear in the text, without recursion.
bool is_too_deep(std::string_view xml) {
  struct Skipped {
    std::string_view begin, end;
  };
  static constexpr std::array kSkipped{Skipped{"<!--", "-->"}, Skipped{"<![CDATA[", "]]>"}, Skipped{"<?", "?>"}};
  int depth = 0;
  for (size_t at = xml.find('<'); at != std::string_view::npos; at = xml.find('<', at)) {
    const std::string_view rest = xml.substr(at);
    bool skipped = false;
    for (const Skipped& part : kSkipped) {
      if (!rest.starts_with(part.begin)) continue;
      at = after(xml, part.end, at + part.begin.size());
      skipped = true;
      break;
    }
    if (skipped) continue;
    const size_t end = after_tag(xml, at + 1);
    if (rest.starts_with("</")) {
      --depth;
    } else if (!rest.starts_with("<!") && (end < 2 || xml[end - 2] != '/') && ++depth > kMaxDepth) {
      return true;
    }
    at = end;
  }
  return false;
}

std::string attribute_of(const tinyxml2::XMLElement* element, const char* name) {
  const char* value = element ? element->Attribute(name) : nullptr;
  return value ? value : "";
}

/// Throws when a link has two parents, or is its own ancestor.
void require_tree(const tinyxml2::XMLElement& robot) {
  struct Parent {
    std::string joint, link;
  };
  std::map<std::string, Parent> parents;  // by child link
  for (auto* joint = robot.FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    const std::string name = attribute_of(joint, "name");
    const std::string child = attribute_of(joint->FirstChildElement("child"), "link");
    const std::string parent = attribute_of(joint->FirstChildElement("parent"), "link");
    if (child.empty() || parent.empty()) continue;  // urdfdom says what is missing
    const auto [known, is_new] = parents.try_emplace(child, Parent{name, parent});
    if (is_new) continue;
    throw std::invalid_argument("joints '" + known->second.joint + "' and '" + name + "' both have the child link '" +
                                child + "'; a link has one parent");
  }
  std::map<std::string, size_t> walks;  // by link: the number of the walk to the root that came by
  size_t walk = 0;
  for (const auto& [first, ignored] : parents) {
    ++walk;
    std::string link = first;
    for (auto up = parents.find(link); up != parents.end(); up = parents.find(link)) {
      const auto [visited, is_new] = walks.try_emplace(link, walk);
      if (!is_new && visited->second == walk) {
        throw std::invalid_argument("joint '" + up->second.joint + "' is part of a cycle of links through '" + link +
                                    "'; the links must form a tree");
      }
      if (!is_new) break;
      link = up->second.link;
    }
  }
}

}  // namespace

void parse_urdf_document(std::string_view urdf_xml, tinyxml2::XMLDocument& document) {
  if (urdf_xml.size() > kMaxText) throw std::invalid_argument("is larger than 16 MB, the most that a URDF may have");
  if (is_too_deep(urdf_xml)) {
    throw std::invalid_argument("is not a valid URDF: elements are nested more than " + std::to_string(kMaxDepth) +
                                " deep");
  }
  if (document.Parse(urdf_xml.data(), urdf_xml.size()) != tinyxml2::XML_SUCCESS) {
    throw std::invalid_argument(std::string("is not a valid URDF: ") + document.ErrorStr());
  }
  const tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  if (!robot) throw std::invalid_argument("is not a valid URDF: it has no element 'robot'");
  int links = 0;
  for (auto* link = robot->FirstChildElement("link"); link; link = link->NextSiblingElement("link")) ++links;
  if (links > kMaxLinks) throw std::invalid_argument("has more than " + std::to_string(kMaxLinks) + " links");
  require_tree(*robot);
}

std::vector<std::string> UrdfTree::ancestry(std::string link) const {
  std::vector<std::string> found;
  while (true) {
    found.push_back(link);
    const auto above = std::ranges::find(joints, link, &Joint::child);
    if (above == joints.end() || above->parent.empty()) return found;
    link = above->parent;
  }
}

UrdfTree urdf_tree(std::string_view urdf_xml) {
  tinyxml2::XMLDocument document;
  parse_urdf_document(urdf_xml, document);
  const auto text = [](const tinyxml2::XMLElement* element, const char* name) -> std::string {
    const char* value = element ? element->Attribute(name) : nullptr;
    return value ? value : "";
  };
  UrdfTree tree;
  const tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  for (auto* link = robot->FirstChildElement("link"); link; link = link->NextSiblingElement("link"))
    tree.links.push_back(text(link, "name"));
  for (auto* joint = robot->FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    tree.joints.push_back({text(joint, "name"), text(joint->FirstChildElement("parent"), "link"),
                           text(joint->FirstChildElement("child"), "link")});
  }
  return tree;
}

}  // namespace multireach
