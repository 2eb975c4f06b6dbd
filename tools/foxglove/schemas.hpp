#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace multireach {

/// JSON schema of a message type that Foxglove and Lichtblick know by its name: foxglove.CameraCalibration,
/// CompressedImage, RawImage, FrameTransforms and SceneUpdate, with the fields of
/// https://docs.foxglove.dev/docs/sdk/schemas. Throws std::invalid_argument for another name.
nlohmann::ordered_json foxglove_schema(const std::string& name);

}  // namespace multireach
