#include "daemon/web/web_service.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "daemon/system/readable.hpp"
#include "daemon/web/page/page_files.hpp"
#include "daemon/web/page/page_methods.hpp"
#include "daemon/web/printer_answer.hpp"
#include "daemon/web/request_checks.hpp"

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

constexpr std::string_view kApi = "/api/", kUploadPath = "/api/upload", kCallPath = "/api/call/";
// The paths that slicers use (PrusaSlicer: OctoPrint.cpp).
constexpr std::string_view kVersionPath = "/api/version", kFilesPath = "/api/files/local",
                           kNewerPath = "/api/v1/";

bool is_get(const HttpRequest& request) {
  return request.method() == "GET" || request.method() == "HEAD";
}

bool is_slicers(const HttpRequest& request) {
  const std::string& path = request.path();
  return path == kVersionPath || path == kFilesPath || path.starts_with(kNewerPath);
}

HttpReply no_such_page() {
  return {.status = 404, .body = "there is no such page\n"};
}

constexpr const char* kNewKey = "sudo contourctl web password makes a new one\n";

// Returns what is wrong with a slicer's user and password.
std::string why_no_digest(const HttpRequest& request) {
  const std::string user = digest_user(request.connection());
  if (user.empty())
    return fmt::format("the API key is missing: send it as X-Api-Key, or as the password of the user {}; {}",
                       kSlicerUser, kNewKey);
  if (user != kSlicerUser)
    return fmt::format("the user {} is unknown: the user of slicers is {}, the password is the API key\n",
                       printable(shortened(user, 100)), kSlicerUser);
  return fmt::format("the password of the user {} is not the API key: {}", kSlicerUser, kNewKey);
}

// Answers with the reason if the role is less than is needed.
[[nodiscard]] bool refuse_role(HttpRequest& request, Role role, Role least) {
  if (role >= least) return false;
  request.answer({.status = 403,
                  .body = fmt::format("this needs the role {}; you have logged in as {}\n", name_of(least),
                                      name_of(role))});
  return true;
}

// Collects a small body.
class SmallBody final : public HttpBody {
 public:
  explicit SmallBody(std::function<void(const std::string& body)> received)
      : received_(std::move(received)) {}
  [[nodiscard]] bool take(std::string_view piece) override {
    body_ += piece;
    return true;
  }
  void end() override { received_(body_); }

 private:
  std::function<void(const std::string& body)> received_;
  std::string body_;
};

}  // namespace

WebService::WebService(EventLoop& loop, const Log& log, const WebConfig& config, WebSecrets secrets,
                       std::vector<std::string> names, std::vector<FileDescriptor> listeners)
    : log_(log),
      names_(std::move(names)),
      login_(loop, std::move(secrets), config.session,
             [this](const std::string& peer, std::optional<Role> role) { log_login(peer, role); }),
      printer_(loop, config.control_socket),
      slow_(loop, config.control_socket, ControlLink::kLongPatience),
      mask_(printer_),
      feed_(loop, config.control_socket),
      disk_(loop, "web-disk"),
      uploads_{
          .disk = disk_,
          .printer = printer_,
          .limits = {.most_bytes = config.largest_upload_bytes, .free_bytes = config.min_free_disk_bytes}},
      server_(loop, std::move(listeners), [this](const RequestPtr& request) { serve(request); }) {
  names_.insert(names_.end(), config.names.begin(), config.names.end());
}

void WebService::serve(const RequestPtr& request) {
  if (refuse_stranger(*request)) return;
  if (!request->path().starts_with("/api/")) return serve_anyone(request);
  if (request->path() == "/api/login" && request->method() == "POST") {
    return receive(request,
                   [this](const RequestPtr& whole, const std::string& body) { login_.log_in(whole, body); });
  }
  const std::optional<Role> role = access_of(*request);
  if (!role) return;
  request->has_logged_in();
  if (is_slicers(*request)) return serve_slicer(request);
  serve_user(request, *role);
}

std::optional<Role> WebService::access_of(HttpRequest& request) const {
  if (login_.has_key(request)) return Role::Print;
  if (const std::optional<Role> role = login_.role_of(request);
      role && (*role != Role::Watch || !is_slicers(request)))
    return role;
  const bool sent_key = !request.header("X-Api-Key").empty();
  HttpReply refusal{.status = 401,
                    .body = sent_key ? std::string("the API key in X-Api-Key is wrong: ") + kNewKey
                                     : "log in first: POST /api/login, or send the API key as X-Api-Key\n"};
  // Elsewhere a browser would open its own dialog for a user and a password.
  if (is_slicers(request)) {
    const DigestCheck digest = login_.digest_of(request);
    if (digest == DigestCheck::Good) return Role::Print;
    if (!sent_key) refusal.body = why_no_digest(request);
    refusal.digest_is_stale = digest == DigestCheck::Stale;
  }
  request.answer(std::move(refusal));
  return std::nullopt;
}

void WebService::serve_slicer(const RequestPtr& request) {
  if (request->path() == kVersionPath) {
    // PrusaSlicer expects a text that begins with "Prusa SLA" from the hosts of its type SL1.
    const Json version{{"api", "0.1"}, {"server", "1.1.0"}, {"text", "Prusa SLA contourd"}};
    return request->answer({.type = "application/json", .body = version.dump()});
  }
  if (request->path() != kFilesPath) return request->answer(no_such_page());
  if (request->method() != "POST")
    return request->answer({.status = 405, .body = "send a model by POST\n", .headers = {{"Allow", "POST"}}});
  if (uploads_.refuse(*request)) return;
  request->receive(std::make_shared<UploadForm>(uploads_, request, "file", "", note_upload(request)),
                   uploads_.most_bytes());
}

bool WebService::refuse_stranger(HttpRequest& request) const {
  const std::string header = request.header("Host");
  if (!is_own_host(host_of(header), request.local(), names_)) {
    request.answer(
        {.status = 403,
         .body = fmt::format("{}: not a name or an address of this printer; further names belong in "
                             "\"names\" of /etc/contourd/web.json\n",
                             header.empty() ? "no Host" : printable(shortened(header, 100)))});
    return true;
  }
  if (is_get(request) && !request.path().starts_with("/api/")) return false;
  if (!is_cross_site({header, request.header("Origin"), request.header("Sec-Fetch-Site")})) return false;
  request.answer(
      {.status = 403, .body = "a page of another site has sent this request; open the printer's page\n"});
  return true;
}

void WebService::serve_anyone(const RequestPtr& request) {
  const PageFile* const file = page_file(request->path());
  if (file == nullptr) return request->answer(no_such_page());
  if (!is_get(*request))
    return request->answer(
        {.status = 405, .body = "this page can only be read\n", .headers = {{"Allow", "GET, HEAD"}}});
  request->answer({.type = file->type, .body = std::string(file->text)});
}

void WebService::serve_user(const RequestPtr& request, Role role) {
  const std::string& path = request->path();
  if (is_get(*request)) {
    if (path == "/api/history") return serve_history(request);
    if (path == "/api/mask") return serve_mask(request);
    if (path == "/api/preview") return serve_preview(request);
    if (path == "/api/report") return serve_report(request);
    if (path == "/api/picture") return serve_picture(request);
    if (path == "/api/time_lapse") return serve_film(request);
    if (path == "/api/events") return serve_events(request);
    if (path == "/api/session") {
      const Json session{{"role", name_of(role)}};
      return request->answer({.type = "application/json", .body = session.dump()});
    }
    return serve_query(request, role);
  }
  if (request->method() != "POST")
    return request->answer(
        {.status = 405, .body = "send GET, HEAD or POST\n", .headers = {{"Allow", "GET, HEAD, POST"}}});
  if (path == "/api/logout") return login_.log_out(*request);
  if (path == kUploadPath) {
    if (refuse_role(*request, role, Role::Print)) return;
    return upload(request);
  }
  if (!path.starts_with(kCallPath)) return request->answer(no_such_page());
  const std::string name = path.substr(kCallPath.size());
  const PageMethod* const method = page_method(name);
  if (method == nullptr)
    return request->answer(
        {.status = 404,
         .body = fmt::format("there is no method \"{}\" for the page\n", printable(shortened(name, 100)))});
  if (refuse_role(*request, role, method->least)) return;
  receive(request, [this, method](const RequestPtr& whole, const std::string& body) {
    pass_on(whole, *method, body);
  });
}

void WebService::serve_events(const RequestPtr& request) {
  if (!feed_.has_room())
    return request->answer(
        {.status = 503,
         .body = fmt::format("{} pages of this printer are open, and no more are possible: close one\n",
                             StatusFeed::kMostPages)});
  if (login_.has_key(*request)) return feed_.serve(request);
  feed_.serve(request, login_.session_of(*request));
}

void WebService::serve_query(const RequestPtr& request, Role role) {
  const PageQuery* const query = page_query(std::string_view(request->path()).substr(kApi.size()));
  if (query == nullptr) return request->answer(no_such_page());
  if (refuse_role(*request, role, query->least)) return;
  Request question{std::string(query->name), Json::object()};
  if (query->parameter != nullptr)
    question.parameters[query->parameter] = request->parameter(query->parameter).value_or("");
  ask(query->waits ? slow_ : printer_, request, std::move(question));
}

void WebService::serve_preview(const RequestPtr& request) {
  fetch_file(slow_, {.method = "preview", .parameters = {{"job", request->parameter("job").value_or("")}}},
             [request](std::string png, const Json& error) {
               if (png.empty()) return request->answer(reply_of({{"error", error}}));
               request->answer({.type = "image/png", .body = std::move(png)});
             });
}

void WebService::receive(const RequestPtr& request, Received received) {
  if (request->body_bytes().value_or(0) > kMostBodyBytes)
    return request->answer(
        {.status = 413, .body = fmt::format("the body has more than {} bytes\n", kMostBodyBytes)});
  request->receive(std::make_shared<SmallBody>([weak = std::weak_ptr(request),
                                                received = std::move(received)](const std::string& body) {
                     if (const RequestPtr whole = weak.lock()) received(whole, body);
                   }),
                   kMostBodyBytes);
}

void WebService::serve_report(const RequestPtr& request) {
  // The report is a page of its own without scripts, and has its style and its pictures in itself.
  constexpr const char* kPolicy =
      "sandbox; default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action "
      "'none'; frame-ancestors 'none'";
  serve_file(request,
             {.method = "report",
              .parameters = {{"job", request->parameter("job").value_or("")}},
              .version = "version"},
             {.type = "text/html; charset=utf-8", .policy = kPolicy});
}

void WebService::serve_picture(const RequestPtr& request) {
  FileQuestion question{.method = "picture",
                        .parameters = {{"job", request->parameter("job").value_or("")}},
                        .version = "version"};
  if (const std::optional<std::string> layer = request->parameter("layer")) {
    const Json number = Json::parse(*layer, nullptr, false);
    question.parameters["layer"] = number.is_number_integer() ? number : Json(*layer);
  }
  serve_file(request, std::move(question), {.type = "image/jpeg"});
}

void WebService::serve_film(const RequestPtr& request) {
  serve_file(request,
             {.method = "time_lapse",
              .parameters = {{"job", request->parameter("job").value_or("")}},
              .version = "version"},
             {.type = "video/mp4"});
}

void WebService::serve_file(const RequestPtr& request, FileQuestion question, HttpReply reply) {
  // use_count() includes the service's own reference.
  if (file_place_.use_count() > kMostFiles)
    return request->answer({.status = 503, .body = "too many files are being read; try again\n"});
  reply.place = file_place_;
  fetch_file(slow_, std::move(question),
             [request, reply = std::move(reply)](std::string bytes, const Json& error) mutable {
               if (bytes.empty()) return request->answer(reply_of({{"error", error}}));
               reply.body = std::move(bytes);
               request->answer(part_of(std::move(reply), request->header("Range")));
             });
}

void WebService::pass_on(const RequestPtr& request, const PageMethod& method, const std::string& parameters) {
  const Json json = parameters.empty() ? Json::object() : Json::parse(parameters, nullptr, false);
  if (!json.is_object())
    return request->answer({.status = 400, .body = "expected the parameters as a JSON object\n"});
  log_.info("command", fmt::format("{} from {}", method.name, request->peer()));
  ask(method.waits ? slow_ : printer_, request, {std::string(method.name), json});
}

void WebService::ask(ControlLink& link, const RequestPtr& request, Request question) {
  link.call(std::move(question), [request](const Json& answer) { request->answer(reply_of(answer)); });
}

void WebService::serve_mask(const RequestPtr& request) {
  mask_.fetch([request](const std::string& png, const Json& error) {
    if (!png.empty()) return request->answer({.type = "image/png", .body = png});
    HttpReply reply = reply_of({{"error", error}});
    if (reply.status == kConflict) reply.status = 404;
    request->answer(std::move(reply));
  });
}

void WebService::serve_history(const RequestPtr& request) {
  constexpr int kJobs = 20;
  Request question{"history", {{"last", kJobs}}};
  if (const std::optional<std::string> before = request->parameter("before")) {
    const Json number = Json::parse(*before, nullptr, false);
    question.parameters["before"] = number.is_number_integer() ? number : Json(*before);
  }
  ask(slow_, request, std::move(question));
}

UploadBody::Stored WebService::note_upload(const RequestPtr& request) const {
  return [this, peer = request->peer()](const std::string& job) {
    log_.info("uploaded", fmt::format("{} from {}", printable(job), peer), job_fields(job));
    const Json body{{"job", job}};
    return HttpReply{.status = 201,
                     .type = "application/json",
                     .body = body.dump(-1, ' ', true, Json::error_handler_t::replace)};
  };
}

void WebService::upload(const RequestPtr& request) {
  if (uploads_.refuse(*request)) return;
  const std::string name = request->parameter("name").value_or("");
  if (name.empty()) return request->answer({.status = 400, .body = "expected the file's name as ?name=\n"});
  const std::string confirm = request->parameter("confirm").value_or("false");
  const std::string ticket(confirm == "0" || confirm == "false" ? "" : kConfirmTicket);
  request->receive(std::make_shared<UploadBody>(uploads_, request, name, ticket, note_upload(request)),
                   uploads_.most_bytes());
}

void WebService::log_login(const std::string& peer, std::optional<Role> role) const {
  if (role)
    log_.info("login", fmt::format("{} has logged in as {}", peer, name_of(*role)));
  else
    log_.warning("login", fmt::format("wrong password from {}", peer));
}

}  // namespace contourd::web
