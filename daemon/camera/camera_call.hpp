// A call of the user's camera: sends what the command gets to know to contourd-camera.socket, whose service
// runs the command, and receives the file that the command has made. contourd itself starts no process.
// Blocks; any thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hw/clock.hpp"

namespace contourd {

// Maximum size of a picture, and of a time lapse.
inline constexpr std::size_t kMostCameraBytes = std::size_t{8} << 20U;

struct CameraCall {
  std::filesystem::path socket;
  // The command's environment, without the prefix CONTOURD_; each value is one printable line, or a path.
  std::vector<std::pair<std::string_view, std::string>> variables;
  Duration patience{};  // real time for all of it
};

// The file; or a clause that says why there is none. Both are empty if the user has no such command.
struct CameraAnswer {
  std::string bytes{}, trouble{};
};

// Calls the camera and waits for its answer, until the patience is over or the descriptor `stop` is readable.
[[nodiscard]] CameraAnswer call_camera(const CameraCall& call, int stop);

// True if the file begins like a JPEG picture (ITU-T T.81: the markers SOI and the next one).
[[nodiscard]] bool is_jpeg(std::string_view bytes);
// True if the file begins like an MP4 film (ISO/IEC 14496-12: a box of the type ftyp).
[[nodiscard]] bool is_mp4(std::string_view bytes);

}  // namespace contourd
