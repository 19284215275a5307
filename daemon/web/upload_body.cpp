#include "daemon/web/upload_body.hpp"

#include <fmt/format.h>
#include <microhttpd.h>

#include <utility>

#include "daemon/web/request_checks.hpp"

namespace contourd::web {
namespace {

constexpr unsigned kBadRequest = 400, kUnavailable = 503, kUnsupported = 415, kCreated = 201;

}  // namespace

UploadBody::UploadBody(UploadPlaces& places, const std::shared_ptr<HttpRequest>& request, UploadedJob job,
                       Stored stored)
    : places_(places), request_(request), job_(std::move(job)), stored_(std::move(stored)) {
  ++places_.under_way;
  if (!job_.name.empty()) set_name(job_.name);
}

UploadBody::~UploadBody() {
  --places_.under_way;
}

void UploadBody::set_name(std::string name) {
  job_.name = std::move(name);
  if (const std::string why = why_bad_file_name(job_.name); !why.empty()) refuse({kUnsupported, why});
}

void UploadBody::refuse(UploadRefusal refusal) {
  if (!refusal_) refusal_ = std::move(refusal);
  upload_.reset();
}

bool UploadBody::put(std::string bytes) {
  if (is_refused()) return true;
  if (upload_) {
    write(std::move(bytes));
  } else {
    open([this, bytes = std::move(bytes)] { write(bytes); });
  }
  return false;
}

void UploadBody::open(std::function<void()> next) {
  places_.printer.call(
      {"status"}, [this, next = std::move(next), alive = std::weak_ptr(alive_)](const auto& answer) {
        if (alive.expired()) return;
        if (answer.contains("result")) {
          upload_.emplace(places_.disk, answer["result"]["spool"].template get<std::string>(), job_,
                          places_.limits);
          return next();
        }
        refuse({kUnavailable, answer["error"]["message"].template get<std::string>()});
        if (const auto waiting = request()) waiting->go_on();
      });
}

void UploadBody::write(std::string bytes) {
  upload_->write(std::move(bytes), [this, alive = std::weak_ptr(alive_)](const auto& refusal) {
    if (alive.expired()) return;
    if (refusal) refuse(*refusal);
    if (const auto waiting = request()) waiting->go_on();
  });
}

void UploadBody::end() {
  if (is_refused()) return reply();
  if (job_.name.empty()) {
    refuse({kBadRequest, "the form has no part \"file\" with a file's name"});
    return reply();
  }
  if (upload_) return finish();
  refuse({kBadRequest, "the file is empty"});
  reply();
}

void UploadBody::finish() {
  upload_->finish([this, alive = std::weak_ptr(alive_)](const auto& refusal, const std::string& job) {
    if (alive.expired()) return;
    if (refusal) refuse(*refusal);
    if (is_refused()) return reply();
    stored_(job);
    const ControlLink::Json body{{"job", job}};
    if (const auto waiting = request())
      waiting->answer({.status = kCreated,
                       .type = "application/json",
                       .body = body.dump(-1, ' ', true, ControlLink::Json::error_handler_t::replace)});
  });
}

void UploadBody::reply() {
  if (const auto waiting = request())
    waiting->answer({.status = refusal_->status, .body = refusal_->why + "\n"});
}

// libmicrohttpd's parser of forms calls this for each piece of a part.
struct UploadForm::Callback {
  static MHD_Result part(void* self, MHD_ValueKind /*kind*/, const char* key, const char* file,
                         const char* /*type*/, const char* /*encoding*/, const char* data,
                         std::uint64_t offset, std::size_t bytes) {
    UploadForm& form = *static_cast<UploadForm*>(self);
    if (offset == 0 && ++form.parts_ > kMostParts) {
      form.refuse({kBadRequest, fmt::format("the form has more than {} parts", kMostParts)});
      return MHD_NO;
    }
    if (std::string_view(key == nullptr ? "" : key) != "file" || file == nullptr) return MHD_YES;
    if (offset == 0 && !form.name().empty()) {
      form.refuse({kBadRequest, "the form has more than one part \"file\"; send one model at a time"});
      return MHD_NO;
    }
    if (offset == 0) form.set_name(*file == '\0' ? "." : file);
    form.bytes_.append(data, bytes);
    return MHD_YES;
  }
};

UploadForm::UploadForm(UploadPlaces& places, const std::shared_ptr<HttpRequest>& request, Stored stored)
    : UploadBody(places, request, {}, std::move(stored)) {
  constexpr std::size_t kBuffer = 8192;
  parser_ = MHD_create_post_processor(request->connection(), kBuffer, &Callback::part, this);
  if (parser_ == nullptr)
    refuse({kUnsupported, "the body is no form: send multipart/form-data with a part \"file\""});
}

UploadForm::~UploadForm() {
  if (parser_ != nullptr) MHD_destroy_post_processor(parser_);
}

bool UploadForm::take(std::string_view piece) {
  if (is_refused() || parser_ == nullptr) return true;
  if (MHD_post_process(parser_, piece.data(), piece.size()) != MHD_YES)
    refuse({kBadRequest, "the form is broken, or one of its parts"});
  std::string bytes = std::exchange(bytes_, {});
  return bytes.empty() || put(std::move(bytes));
}

void UploadForm::end() {
  // The parser tells the end of a form that was cut off.
  if (parser_ != nullptr && MHD_destroy_post_processor(std::exchange(parser_, nullptr)) != MHD_YES)
    refuse({kBadRequest, "the form ends before its last part does"});
  if (is_refused() || bytes_.empty()) return UploadBody::end();
  refuse({kBadRequest, "the form is broken"});
  UploadBody::end();
}

}  // namespace contourd::web
