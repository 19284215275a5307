#include "daemon/web/hosts/nanodlp_upload.hpp"

#include <fmt/format.h>

#include <utility>

#include "daemon/formats/model_names.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/web/hosts/host_replies.hpp"
#include "daemon/web/hosts/nanodlp_replies.hpp"

namespace contourd::web {
namespace {

constexpr unsigned kMovedTo = 302, kBadRequest = 400, kForbidden = 403;
constexpr std::string_view kExtension = ".nanodlp";

// Returns the reply for a stored plate: DragonFruit and Orion read its number at the end of Location.
UploadBody::Stored reply_with_number(HostPrinter& printer, const std::shared_ptr<HttpRequest>& request) {
  return [&printer, weak = std::weak_ptr(request)](const std::string& job) {
    if (const auto waiting = weak.lock()) printer.note_upload(*waiting, job);
    return HttpReply{.status = kMovedTo,
                     .type = "application/json",
                     .body = ascii_of({{"PlateID", id_of(job)}}),
                     .headers = {{"Location", fmt::format("/plate/{}", id_of(job))}}};
  };
}

}  // namespace

NanodlpUpload::NanodlpUpload(HostPrinter& printer, const std::shared_ptr<HttpRequest>& request)
    : UploadForm(printer.uploads(), request, "ZipFile", std::string(kConfirmTicket),
                 reply_with_number(printer, request)),
      printer_(printer) {}

std::optional<std::string> NanodlpUpload::name_of(const char* file) const {
  if (path_.empty()) return UploadForm::name_of(file);
  return model_extension(path_).empty() ? path_ + std::string(kExtension) : path_;
}

void NanodlpUpload::take_field(std::string_view key, std::string_view piece, bool begins) {
  if (key == "USBFile" && !piece.empty())
    return refuse(
        {kForbidden,
         "the printer takes no file by its path: send the file, or let the printer's own reader of USB "
         "sticks take it"});
  if (key != "Path" && key != "ProfileID") return;
  std::string& field = key == "Path" ? path_ : profile_;
  if (begins && !field.empty())
    return refuse({kBadRequest, fmt::format("the form has more than one {}: send one plate at a time", key)});
  field += piece;
  if (field.size() > kLongestField)
    refuse({kBadRequest, fmt::format("{} has more than {} bytes", key, kLongestField)});
}

void NanodlpUpload::settle_ticket(std::function<void()> next) {
  const std::shared_ptr<HttpRequest> waiting = request();
  if (profile_.empty() || !waiting) return next();
  printer_.ask(waiting, {{"resins"}}, [this, alive = guard(), next = std::move(next)](const auto& results) {
    if (alive.expired()) return;
    if (const std::optional<std::string> resin = nanodlp_resin(results[0], profile_))
      set_ticket(ascii_of({{"confirm", true}, {"resin", *resin}}) + "\n");
    else
      refuse(
          {kBadRequest, fmt::format("the printer has no resin profile with the number {}: read the profiles "
                                    "again",
                                    printable(profile_))});
    next();
  });
}

}  // namespace contourd::web
