#include "daemon/web/printer/fetched_file.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "daemon/system/base64.hpp"

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

struct Fetch {
  ControlLink& printer;
  FileQuestion question;
  FileFetched fetched;
  std::string bytes{};
};

void ask(const std::shared_ptr<Fetch>& fetch, Json parameters);

void take(const std::shared_ptr<Fetch>& fetch, const Json& answer) {
  if (!answer.contains("result")) return fetch->fetched({}, answer.value("error", Json::object()));
  const Json& piece = answer["result"];
  const std::optional<std::vector<std::uint8_t>> data = from_base64(piece.value("data", ""));
  const std::size_t whole = piece.value("bytes", std::size_t{0});
  if (!data || data->empty() || whole > fetch->question.most_bytes)
    return fetch->fetched(
        {}, {{"code", kNoFile}, {"message", "contourd has sent no file, or one that is too large"}});
  fetch->bytes.append(data->begin(), data->end());
  if (fetch->bytes.size() >= whole) return fetch->fetched(std::move(fetch->bytes), {});
  Json parameters = fetch->question.parameters;
  parameters[fetch->question.version] = piece[fetch->question.version];
  parameters["from"] = fetch->bytes.size();
  ask(fetch, std::move(parameters));
}

void ask(const std::shared_ptr<Fetch>& fetch, Json parameters) {
  fetch->printer.call({fetch->question.method, std::move(parameters)},
                      [fetch](const Json& answer) { take(fetch, answer); });
}

}  // namespace

void fetch_file(ControlLink& printer, FileQuestion question, FileFetched fetched) {
  const auto fetch = std::make_shared<Fetch>(Fetch{printer, std::move(question), std::move(fetched)});
  ask(fetch, fetch->question.parameters);
}

}  // namespace contourd::web
