#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

namespace multireach {

/// The files of a set-up, as the command-line tools write them, and the few numbers that belong to none of them.
class CourseFolder {
 public:
  /// What the user told.
  struct Settings {
    int columns = 0, rows = 0;  ///< of the chessboard's inner corners; 0: not known yet
    double square_m = 0.025;
    double radius_m = 0;                    ///< of the ball; 0: the object is none
    std::optional<Eigen::Vector3d> p_HT{};  ///< the target in the hand's frame, m
  };

  /// Makes the folder where it does not exist, and reads its settings. Throws InputError.
  explicit CourseFolder(std::string path);

  const std::string& path() const { return path_; }
  std::string boards() const { return path_ + "/board"; }
  std::string stereo() const { return path_ + "/stereo.yaml"; }
  std::string colour() const { return path_ + "/ball.colour.yaml"; }
  std::string pose() const { return path_ + "/pose.yaml"; }
  std::string vision() const { return path_ + "/vision.yaml"; }
  std::string check() const { return path_ + "/check.json"; }

  static bool exists(const std::string& file);
  /// Removes files of a step that is done again.
  static void remove(const std::string& file_or_folder);

  const Settings& settings() const { return settings_; }
  void change(const Settings& settings);
  /// Writes vision.yaml, which names the files that exist; once cameras and colour are known.
  void write_vision() const;

 private:
  std::string path_;
  Settings settings_;
};

}  // namespace multireach
