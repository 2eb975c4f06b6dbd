#include "tools/foxglove/schemas.hpp"

#include <stdexcept>

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

const json kBytes = {{"type", "string"}, {"contentEncoding", "base64"}};
const json kText = {{"type", "string"}};
const json kInteger = {{"type", "integer"}};
const json kNumber = {{"type", "number"}};
const json kFlag = {{"type", "boolean"}};

json object(const std::string& title, const json& properties) {
  return {{"title", title}, {"type", "object"}, {"properties", properties}};
}
json list(const json& items) {
  return {{"type", "array"}, {"items", items}};
}
json time_of(const char* title) {
  return object(title, {{"sec", {{"type", "integer"}, {"minimum", 0}}},
                        {"nsec", {{"type", "integer"}, {"minimum", 0}, {"maximum", 999999999}}}});
}
json vector(const char* title) {
  return object(title, {{"x", kNumber}, {"y", kNumber}, {"z", kNumber}});
}
json quaternion() {
  return object("foxglove.Quaternion", {{"x", kNumber}, {"y", kNumber}, {"z", kNumber}, {"w", kNumber}});
}
json pose() {
  return object("foxglove.Pose", {{"position", vector("foxglove.Vector3")}, {"orientation", quaternion()}});
}
json colour() {
  return object("foxglove.Color", {{"r", kNumber}, {"g", kNumber}, {"b", kNumber}, {"a", kNumber}});
}

/// A primitive with a pose and a colour.
json primitive(const char* title, json properties) {
  properties["pose"] = pose();
  properties["color"] = colour();
  return object(title, properties);
}

/// A list that is always empty here.
json none_of(const char* title) {
  return list(object(title, json::object()));
}

json entity() {
  const json size = vector("foxglove.Vector3");
  return object(
      "foxglove.SceneEntity",
      {{"timestamp", time_of("time")},
       {"frame_id", kText},
       {"id", kText},
       {"lifetime", time_of("duration")},
       {"frame_locked", kFlag},
       {"metadata", none_of("foxglove.KeyValuePair")},
       {"arrows", none_of("foxglove.ArrowPrimitive")},
       {"cubes", list(primitive("foxglove.CubePrimitive", {{"size", size}}))},
       {"spheres", list(primitive("foxglove.SpherePrimitive", {{"size", size}}))},
       {"cylinders", list(primitive("foxglove.CylinderPrimitive",
                                    {{"size", size}, {"bottom_scale", kNumber}, {"top_scale", kNumber}}))},
       {"lines", none_of("foxglove.LinePrimitive")},
       {"triangles", none_of("foxglove.TriangleListPrimitive")},
       {"models", none_of("foxglove.ModelPrimitive")},
       {"texts",
        list(primitive("foxglove.TextPrimitive",
                       {{"billboard", kFlag}, {"font_size", kNumber}, {"scale_invariant", kFlag}, {"text", kText}}))}});
}

}  // namespace

nlohmann::ordered_json foxglove_schema(const std::string& name) {
  const json timestamp = time_of("time");
  if (name == "foxglove.CompressedImage")
    return object(name, {{"timestamp", timestamp}, {"frame_id", kText}, {"data", kBytes}, {"format", kText}});
  if (name == "foxglove.RawImage") {
    return object(name, {{"timestamp", timestamp},
                         {"frame_id", kText},
                         {"width", kInteger},
                         {"height", kInteger},
                         {"encoding", kText},
                         {"step", kInteger},
                         {"data", kBytes}});
  }
  if (name == "foxglove.CameraCalibration") {
    return object(name, {{"timestamp", timestamp},
                         {"frame_id", kText},
                         {"width", kInteger},
                         {"height", kInteger},
                         {"distortion_model", kText},
                         {"D", list(kNumber)},
                         {"K", list(kNumber)},
                         {"R", list(kNumber)},
                         {"P", list(kNumber)}});
  }
  if (name == "foxglove.FrameTransforms") {
    const json transform = object("foxglove.FrameTransform", {{"timestamp", timestamp},
                                                              {"parent_frame_id", kText},
                                                              {"child_frame_id", kText},
                                                              {"translation", vector("foxglove.Vector3")},
                                                              {"rotation", quaternion()}});
    return object(name, {{"transforms", list(transform)}});
  }
  if (name == "foxglove.SceneUpdate") {
    const json deletion =
        object("foxglove.SceneEntityDeletion", {{"timestamp", timestamp}, {"type", kInteger}, {"id", kText}});
    return object(name, {{"deletions", list(deletion)}, {"entities", list(entity())}});
  }
  throw std::invalid_argument("'" + name + "' is no schema of Foxglove that is known here");
}

}  // namespace multireach
