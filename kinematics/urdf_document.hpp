#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tinyxml2 {
class XMLDocument;
}

namespace multireach {

/// Parses the text of a URDF as XML into `document`, and checks what the readers of URDFs do not: that its size is
/// bounded (16 MB, 64 nested elements, 2000 links), and that no link has two parents or is its own ancestor. Throws
/// std::invalid_argument with one sentence (the caller adds the file name). The document then has an element `robot`.
void parse_urdf_document(std::string_view urdf_xml, tinyxml2::XMLDocument& document);

/// Names of the links and joints of a URDF, in the order of the file.
struct UrdfTree {
  struct Joint {
    std::string name, parent, child;
  };
  std::vector<std::string> links;
  std::vector<Joint> joints;

  /// The link, its parent, and so on up to the root.
  std::vector<std::string> ancestry(std::string link) const;
};
/// Throws as parse_urdf_document().
UrdfTree urdf_tree(std::string_view urdf_xml);

}  // namespace multireach
