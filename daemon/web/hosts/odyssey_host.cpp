#include "daemon/web/hosts/odyssey_host.hpp"

#include <charconv>
#include <optional>
#include <system_error>
#include <utility>

#include "daemon/web/hosts/host_replies.hpp"
#include "daemon/web/hosts/odyssey_replies.hpp"

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

constexpr std::size_t kLargestPage = 1000;

HostPrinter::Done done_for(const std::shared_ptr<HttpRequest>& request) {
  return [request] { answer_done(*request); };
}

void refuse_odyssey_path(HttpRequest& request) {
  refuse_host_request(request, 404, "the printer's interface for Odyssey's clients has no such path");
}

// Answers with the reason if the request is about a USB stick.
[[nodiscard]] bool refuse_usb(HttpRequest& request) {
  if (request.parameter("location").value_or("Local") == "Local") return false;
  refuse_host_request(request, 404, "the printer has no such place for files: its only one is Local");
  return true;
}

// Calls `serve` with the job that file_path names; answers the request if it names none.
template <typename Serve>
void with_file(HttpRequest& request, Serve serve) {
  if (refuse_usb(request)) return;
  const std::string path = request.parameter("file_path").value_or("");
  if (path.empty()) return refuse_host_request(request, 400, "expected a file of the list as ?file_path=");
  serve(HostJobKey{.file = path});
}

// Returns a number of the query, the default without one; nullopt if the text is none, or out of range.
std::optional<std::size_t> number_in(const HttpRequest& request, const char* name, std::size_t by_default,
                                     std::size_t least) {
  const std::string text = request.parameter(name).value_or("");
  if (text.empty()) return by_default;
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc{} && end == text.data() + text.size();
  return is_number && number >= least && number <= kLargestPage ? std::optional(number) : std::nullopt;
}

}  // namespace

OdysseyHost::OdysseyHost(EventLoop& loop, HostPrinter& printer, HostAccess access, std::string version,
                         std::vector<FileDescriptor> listeners)
    : version_(std::move(version)),
      printer_(printer),
      feed_(loop, printer_.control_socket(),
            [this](const Json& status) {
              return status.contains("unreachable") ? "" : odyssey_event(printer_.reader().read(status));
            }),
      server_(loop, std::move(listeners),
              for_clients_only(std::move(access), [this](const RequestPtr& request) { serve(request); })) {}

void OdysseyHost::serve(const RequestPtr& request) {
  // Orion's emergency stop, which moves nothing and lights nothing.
  if (request->method() == "POST" && request->path() == "/manual/hardware_command" &&
      request->parameter("command") == "M112")
    return printer_.stop_all(request, done_for(request));
  if (request->path().starts_with("/manual")) return refuse_host_request(*request, 403, kByHandSentence);
  if (request->method() == "GET") return serve_get(request);
  if (request->method() == "POST") return serve_post(request);
  if (request->method() != "DELETE" || request->path() != "/file")
    return request->answer(
        {.status = 405, .body = "no such method\n", .headers = {{"Allow", "GET, POST, DELETE"}}});
  with_file(*request, [&](const HostJobKey& key) {
    printer_.remove(request, key,
                    [request](const HostJob& job) { answer_json(*request, odyssey_file_data(job)); });
  });
}

void OdysseyHost::serve_get(const RequestPtr& request) {
  const std::string& path = request->path();
  if (path == "/status")
    return printer_.read_status(
        request, [request](const HostStatus& status) { answer_json(*request, odyssey_status(status)); });
  if (path == "/status/stream") return serve_events(request);
  if (path == "/files") return serve_files(request);
  if (path == "/config") return serve_config(request);
  if (path == "/version") return request->answer({.body = "contourd " + version_});
  if (path == "/file/thumbnail")
    return with_file(*request, [&](const HostJobKey& key) { printer_.show(request, key); });
  if (path == "/file/metadata")
    return with_file(*request, [&](const HostJobKey& key) {
      printer_.find(request, key, [request](const HostJob& job, const auto&) {
        answer_json(*request, odyssey_metadata(job));
      });
    });
  if (path == "/file")
    return refuse_host_request(*request, 501, "the printer hands out no files: they are in its spool");
  refuse_odyssey_path(*request);
}

void OdysseyHost::serve_post(const RequestPtr& request) {
  const std::string& path = request->path();
  if (path == "/files") return upload(request);
  if (path == "/print/start")
    return with_file(*request,
                     [&](const HostJobKey& key) { printer_.start(request, key, done_for(request)); });
  for (const char* command : {"pause", "resume", "cancel"})
    if (path == std::string("/print/") + command)
      return printer_.control(request, command, done_for(request));
  refuse_odyssey_path(*request);
}

void OdysseyHost::serve_events(const RequestPtr& request) {
  if (feed_.has_room()) return feed_.serve(request);
  refuse_host_request(*request, 503, "too many clients follow the status");
}

void OdysseyHost::serve_files(const RequestPtr& request) {
  if (refuse_usb(*request)) return;
  if (!request->parameter("subdirectory").value_or("").empty())
    return refuse_host_request(*request, 404, "the printer has no folders of jobs");
  const std::optional<std::size_t> index = number_in(*request, "page_index", 0, 0),
                                   size = number_in(*request, "page_size", OdysseyPage{}.size, 1);
  if (!index || !size)
    return refuse_host_request(*request, 400, "expected page_index from 0 and page_size from 1, up to 1000");
  printer_.list_jobs(request, [request, page = OdysseyPage{*index, *size}](const std::vector<HostJob>& jobs) {
    answer_json(*request, odyssey_files(jobs, page));
  });
}

void OdysseyHost::serve_config(const RequestPtr& request) {
  printer_.ask(request, {{"status"}, {"methods"}}, [this, request](const auto& results) {
    answer_json(*request, odyssey_config(printer_.reader().read(results[0]).printer, results[1]));
  });
}

void OdysseyHost::upload(const RequestPtr& request) {
  if (printer_.uploads().refuse(*request)) return;
  UploadBody::Stored stored = [this, weak = std::weak_ptr(request)](const std::string& job) {
    if (const RequestPtr waiting = weak.lock()) printer_.note_upload(*waiting, job);
    return HttpReply{};
  };
  request->receive(std::make_shared<UploadForm>(printer_.uploads(), request, "file",
                                                std::string(kConfirmTicket), std::move(stored)),
                   printer_.uploads().most_bytes());
}

}  // namespace contourd::web
