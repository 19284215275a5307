#include "daemon/ctl/commands/commands.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/picture_output.hpp"
#include "daemon/system/base64.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

using Json = DaemonConnection::Json;

// The daemon's reason why there is no picture.
class Refused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

Json ask(DaemonConnection& connection, const Json& parameters) {
  Json answer = connection.ask({"mask", parameters});
  if (answer.contains("error")) throw Refused(answer["error"].value("message", ""));
  return std::move(answer["result"]);
}

std::vector<std::uint8_t> piece_in(const Json& reply) {
  const auto piece = from_base64(reply.at("data").get_ref<const std::string&>());
  if (!piece || piece->empty()) throw std::runtime_error("a piece of the picture is empty or damaged");
  return *piece;
}

// Fetches the remaining pieces of a picture. Returns the whole picture.
std::vector<std::uint8_t> rest_of(DaemonConnection& connection, const Json& first) {
  const auto size = first.at("bytes").get<std::size_t>();
  std::vector<std::uint8_t> bytes = piece_in(first);
  while (bytes.size() < size) {
    const auto piece = piece_in(ask(connection, {{"picture", first.at("picture")}, {"from", bytes.size()}}));
    bytes.insert(bytes.end(), piece.begin(), piece.end());
  }
  return bytes;
}

std::string note_of(const Json& reply) {
  const std::string name = printable(reply.value("name", ""));
  const Json& layer = reply.at("layer");
  const std::string what = layer.is_number()
                               ? fmt::format("{}: layer {}, cut at {:.3f} mm", name,
                                             layer.get<std::int64_t>(), reply.at("cut_at_mm").get<double>())
                               : name;
  return what + (reply.value("on_screen", false) ? "; on the screen" : "; the screen is black now");
}

NotedPicture fetch(DaemonConnection& connection) {
  const Json first = ask(connection, Json::object());
  const std::vector<std::uint8_t> png = rest_of(connection, first);
  return {decode_png(png, Pixels{first.at("width").get<std::int32_t>()},
                     Pixels{first.at("height").get<std::int32_t>()}),
          note_of(first), true};
}

// Fetches the picture; starts again if a new mask replaces it between two pieces.
NotedPicture fetch_patiently(DaemonConnection& connection) {
  constexpr int kAttempts = 5;
  for (int attempt = 1;; ++attempt) {
    try {
      return fetch(connection);
    } catch (const Refused&) {
      if (attempt == kAttempts) throw;
      // Throws if there is no mask at all.
      (void)ask(connection, Json::object());
    }
  }
}

int mask(const ClientOptions& client, const std::optional<std::filesystem::path>& output) {
  check_picture_output(output);
  DaemonConnection connection(client.socket);
  NotedPicture picture;
  try {
    picture = fetch_patiently(connection);
  } catch (const Refused& refusal) {
    fmt::print(stderr, "contourctl: {}\n", printable_lines(refusal.what()));
    return kFailed;
  } catch (const DaemonError&) {
    throw;
  } catch (const std::exception& error) {
    throw DaemonError(
        fmt::format("contourd on {} sent no picture: {}", client.socket.string(), error.what()));
  }
  put_out(picture, output);
  return kOk;
}

}  // namespace

void add_mask(Command& program) {
  Command& command = program.add("mask", "Draw the picture on the display, such as the current layer's mask");
  auto& output = command.arguments<std::optional<std::filesystem::path>>();
  command.option("-o,--output", output, kPictureHelp);
  const ClientOptions& client = add_socket_option(command);
  command.run = [&client, &output] { return mask(client, output); };
}

}  // namespace contourd::ctl
