#include "daemon/web/upload_body.hpp"

#include <fmt/format.h>
#include <microhttpd.h>

#include <utility>

#include "daemon/web/request_checks.hpp"

namespace contourd::web {
namespace {

constexpr unsigned kBadRequest = 400, kUnavailable = 503, kUnsupported = 415;

}  // namespace

bool UploadPlaces::refuse(HttpRequest& request) const {
  if (under_way >= kMostUploads) {
    request.answer({.status = kUnavailable, .body = "too many uploads at once; try again later\n"});
    return true;
  }
  if (request.body_bytes().value_or(0) <= limits.most_bytes + kMostBeside) return false;
  request.answer({.status = 413,
                  .body = fmt::format("the model is too large: the printer takes models of at most {} MiB\n",
                                      limits.most_bytes >> 20U)});
  return true;
}

UploadBody::UploadBody(UploadPlaces& places, const std::shared_ptr<HttpRequest>& request, std::string name,
                       std::string ticket, Stored stored)
    : places_(places), request_(request), ticket_(std::move(ticket)), stored_(std::move(stored)) {
  ++places_.under_way;
  if (!name.empty()) set_name(std::move(name));
}

UploadBody::~UploadBody() {
  --places_.under_way;
}

void UploadBody::set_name(std::string name) {
  name_ = std::move(name);
  if (const std::string why = why_bad_file_name(name_); !why.empty()) refuse({kUnsupported, why});
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
          upload_.emplace(places_.disk, answer["result"]["spool"].template get<std::string>(), name_,
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
  if (!upload_) {
    refuse({kBadRequest, "the file is empty"});
    return reply();
  }
  settle_ticket([this, alive = guard()] {
    if (!alive.expired()) finish();
  });
}

void UploadBody::finish() {
  if (is_refused()) return reply();
  upload_->finish(ticket_, [this, alive = guard()](const auto& refusal, const std::string& job) {
    if (alive.expired()) return;
    if (refusal) refuse(*refusal);
    if (is_refused()) return reply();
    HttpReply stored = stored_(job);
    if (const auto waiting = request()) waiting->answer(std::move(stored));
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
    const std::string_view name = key == nullptr ? "" : key;
    if (name != form.part_) {
      form.take_field(name, {data, bytes}, offset == 0);
      return MHD_YES;
    }
    const std::optional<std::string> model = form.name_of(file);
    if (!model) return MHD_YES;
    if (offset == 0 && !form.name().empty()) {
      form.refuse(
          {kBadRequest,
           fmt::format("the form has more than one part \"{}\"; send one model at a time", form.part_)});
      return MHD_NO;
    }
    if (offset == 0) form.set_name(*model);
    form.bytes_.append(data, bytes);
    return MHD_YES;
  }
};

UploadForm::UploadForm(UploadPlaces& places, const std::shared_ptr<HttpRequest>& request, const char* part,
                       std::string ticket, Stored stored)
    : UploadBody(places, request, "", std::move(ticket), std::move(stored)), part_(part) {
  constexpr std::size_t kBuffer = 8192;
  parser_ = MHD_create_post_processor(request->connection(), kBuffer, &Callback::part, this);
  if (parser_ == nullptr)
    refuse({kUnsupported,
            fmt::format("the body is no form: send multipart/form-data with a part \"{}\"", part_)});
}

std::optional<std::string> UploadForm::name_of(const char* file) const {
  if (file == nullptr) return std::nullopt;
  return *file == '\0' ? "." : file;
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
  if (!bytes_.empty()) refuse({kBadRequest, "the form is broken"});
  if (name().empty())
    refuse({kBadRequest, fmt::format("the form has no part \"{}\" with a file's name", part_)});
  UploadBody::end();
}

}  // namespace contourd::web
