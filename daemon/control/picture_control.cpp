#include "daemon/control/picture_control.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "daemon/control/file_pieces.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

using Json = ControlMethod::Json;

constexpr double kMostLayer = 1'000'000;

// Returns the folder of a job's pictures. Blocks. Throws ControlRefusal.
std::filesystem::path folder_of(const PictureFolders& folders, const std::string& job) {
  std::filesystem::path folder;
  if (is_own_name(job)) folder = folders.find(job);
  if (folder.empty()) throw ControlRefusal(fmt::format("there are no pictures of {}", in_quotes(job)));
  return folder;
}

bool has_film(const std::filesystem::path& folder) {
  std::error_code code;
  return std::filesystem::is_regular_file(std::filesystem::symlink_status(film_file(folder), code));
}

Json pictures(const PictureFolders& folders, const std::string& job) {
  const std::filesystem::path folder = folder_of(folders, job);
  Json layers = Json::array();
  for (const std::int32_t layer : pictures_in(folder).layers)
    layers.push_back(layer + 1);
  return {{"job", job}, {"layers", std::move(layers)}, {"time_lapse", has_film(folder)}};
}

// A layer is counted from 1; without one, the last picture is meant.
Json picture(const PictureFolders& folders, const std::string& job, std::optional<std::int32_t> layer,
             const WantedPiece& wanted) {
  const std::filesystem::path folder = folder_of(folders, job);
  if (!layer) {
    const StoredPictures stored = pictures_in(folder);
    if (stored.layers.empty())
      throw ControlRefusal(fmt::format("there are no pictures of {}", in_quotes(job)));
    layer = stored.layers.back() + 1;
  }
  Json reply{{"job", job}, {"layer", *layer}};
  add_piece(reply, picture_file(folder, *layer - 1), wanted);
  return reply;
}

Json film(const PictureFolders& folders, const std::string& job, const WantedPiece& wanted) {
  const std::filesystem::path folder = folder_of(folders, job);
  if (!has_film(folder)) throw ControlRefusal(fmt::format("there is no time lapse of {}", in_quotes(job)));
  Json reply{{"job", job}};
  add_piece(reply, film_file(folder), wanted);
  return reply;
}

}  // namespace

ControlMethods PictureControl::methods() {
  const ControlParameter job = ControlParameter::text("job", "the job's name, as in the history").needed();
  const ControlParameter version = piece_parameter("version", "the version of the file, for the next piece");
  const ControlParameter from =
      piece_parameter("from", "position of the piece: the number of bytes received");
  using Later = ControlMethod::Later;
  const auto name_in = [](const Json& given) { return given["job"].get<std::string>(); };
  return {
      {"pictures",
       {.description = "Lists the pictures that the camera has taken of a print.",
        .parameters = {job},
        .call_later =
            [this, name_in](const Json& given, const ControlCaller&, Later later) {
              read_later(spool_, std::move(later),
                         [this, name = name_in(given)] { return pictures(folders_, name); });
            }}},
      {"picture",
       {.description = "Returns a picture that the camera has taken of a print, in pieces of a JPEG file.",
        .parameters = {job,
                       ControlParameter::whole_number("layer", 1, kMostLayer,
                                                      "the picture's layer; without it, the last picture"),
                       version, from},
        .call_later =
            [this, name_in](const Json& given, const ControlCaller&, Later later) {
              const auto layer = given_value<std::int32_t>(given, "layer");
              read_later(spool_, std::move(later),
                         [this, name = name_in(given), layer, wanted = wanted_piece("the picture", given)] {
                           return picture(folders_, name, layer, wanted);
                         });
            }}},
      {"time_lapse",
       {.description = "Returns the time lapse of a print, in pieces of an MP4 file.",
        .parameters = {job, version, from},
        .call_later = [this, name_in](const Json& given, const ControlCaller&, Later later) {
          read_later(spool_, std::move(later),
                     [this, name = name_in(given), wanted = wanted_piece("the time lapse", given)] {
                       return film(folders_, name, wanted);
                     });
        }}}};
}

}  // namespace contourd
