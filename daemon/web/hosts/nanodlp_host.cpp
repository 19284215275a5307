#include "daemon/web/hosts/nanodlp_host.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "daemon/web/hosts/host_replies.hpp"
#include "daemon/web/hosts/nanodlp_replies.hpp"
#include "daemon/web/hosts/nanodlp_upload.hpp"

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

constexpr std::string_view kPrinter = "/printer/", kDelete = "/plate/delete/", kPlates = "/static/plates/";

// Returns a function that answers the request with nothing, which is success.
HostPrinter::Done success(const std::shared_ptr<HttpRequest>& request) {
  return [request] { answer_done(*request); };
}

void refuse_path(HttpRequest& request) {
  refuse_host_request(request, 404, "the printer's interface for NanoDLP's clients has no such path");
}

// Answers with the reason if the path is one for what is done by hand, or changes a resin profile.
[[nodiscard]] bool refuse_by_hand(HttpRequest& request) {
  constexpr std::array<std::string_view, 5> kByHand{"/z-axis/", "/projector/", "/gcode", "/display/",
                                                    "/athena-iot/control/"};
  const auto begins = [&request](std::string_view with) { return request.path().starts_with(with); };
  if (std::ranges::any_of(kByHand, begins)) {
    refuse_host_request(request, 403, kByHandSentence);
    return true;
  }
  if (!begins("/profile/")) return false;
  refuse_host_request(request, 403, "resin profiles are changed only at the printer");
  return true;
}

// Calls `serve` with the number of a plate at the end of the path; answers the request if there is none.
template <typename Serve>
void with_plate(HttpRequest& request, std::string_view text, Serve serve) {
  if (const std::optional<std::uint32_t> id = nanodlp_number(text)) return serve(HostJobKey{.id = id});
  refuse_host_request(request, 400, "expected the number of a plate at the end of the path");
}

}  // namespace

NanodlpHost::NanodlpHost(EventLoop& loop, HostPrinter& printer, HostAccess access, std::string version,
                         std::vector<FileDescriptor> listeners)
    : version_(std::move(version)),
      printer_(printer),
      server_(loop, std::move(listeners),
              for_clients_only(std::move(access), [this](const RequestPtr& request) { serve(request); })) {}

void NanodlpHost::serve(const RequestPtr& request) {
  if (refuse_by_hand(*request)) return;
  const bool is_add = request->path() == "/plate/add";
  if (request->method() != (is_add ? "POST" : "GET"))
    return request->answer({.status = 405,
                            .body = is_add ? "send a plate by POST\n" : "this path takes GET only\n",
                            .headers = {{"Allow", is_add ? "POST" : "GET"}}});
  if (!is_add) return serve_get(request);
  if (printer_.uploads().refuse(*request)) return;
  request->receive(std::make_shared<NanodlpUpload>(printer_, request), printer_.uploads().most_bytes());
}

void NanodlpHost::serve_get(const RequestPtr& request) {
  const std::string_view path = request->path();
  if (path == "/status")
    return printer_.read_status(request, [this, request](const HostStatus& status) {
      answer_json(*request, nanodlp_status(status, version_));
    });
  if (path == "/plates/list/json")
    return printer_.list_jobs(request, [request](const std::vector<HostJob>& jobs) {
      answer_json(*request, nanodlp_plates(jobs));
    });
  if (path == "/json/db/profiles.json")
    return printer_.ask(request, {{"resins"}}, [request](const auto& results) {
      answer_json(*request, nanodlp_profiles(results[0]));
    });
  if (path == "/json/db/machine.json") return serve_machine(request);
  if (path == "/notification") return answer_json(*request, Json::array());
  if (path == "/static/image_version") return request->answer({.body = "contourd+" + version_});
  if (path.starts_with(kPrinter)) return serve_command(request, path.substr(kPrinter.size()));
  if (path.starts_with(kPlates)) return serve_picture(request, path.substr(kPlates.size()));
  if (!path.starts_with(kDelete)) return refuse_path(*request);
  with_plate(*request, path.substr(kDelete.size()), [&](const HostJobKey& key) {
    printer_.remove(request, key, [request](const HostJob&) { answer_done(*request); });
  });
}

void NanodlpHost::serve_machine(const RequestPtr& request) {
  printer_.ask(request, {{"status"}, {"resins"}}, [this, request](const auto& results) {
    answer_json(*request, nanodlp_machine(printer_.reader().read(results[0]).printer, results[1]));
  });
}

void NanodlpHost::serve_command(const RequestPtr& request, std::string_view command) {
  constexpr std::string_view kStart = "start/";
  constexpr std::array kCommands{std::pair{"pause", "pause"}, std::pair{"unpause", "resume"},
                                 std::pair{"resume", "resume"}, std::pair{"stop", "cancel"},
                                 std::pair{"cancel", "cancel"}};
  if (command.starts_with(kStart))
    return with_plate(*request, command.substr(kStart.size()),
                      [&](const HostJobKey& key) { printer_.start(request, key, success(request)); });
  if (command == "force-stop") return printer_.stop_all(request, success(request));
  const auto* const found =
      std::ranges::find(kCommands, command, [](const auto& each) { return std::string_view(each.first); });
  if (found == kCommands.end()) return refuse_path(*request);
  printer_.control(request, found->second, success(request));
}

// Serves ID/3d.png, a picture of a waiting job, and ID/N.png, the present layer of the print under way.
void NanodlpHost::serve_picture(const RequestPtr& request, std::string_view place) {
  constexpr std::string_view kPng = ".png";
  const std::size_t slash = place.find('/');
  if (slash == std::string_view::npos || !place.ends_with(kPng)) return refuse_path(*request);
  std::string_view picture = place.substr(slash + 1);
  picture.remove_suffix(kPng.size());
  with_plate(*request, place.substr(0, slash), [&](const HostJobKey& key) {
    if (picture == "3d") return printer_.show(request, key);
    const std::optional<std::uint32_t> layer = nanodlp_number(picture);
    printer_.read_status(request, [this, request, key, layer](const HostStatus& status) {
      if (layer && status.job && status.job->id() == key.id && status.layer == *layer)
        return printer_.show_mask(request);
      refuse_host_request(*request, 404, "only the layer that is being printed has a picture");
    });
  });
}

}  // namespace contourd::web
