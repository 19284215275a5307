#include "daemon/formats/model_input.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "core/formats/model_reader.hpp"
#include "daemon/formats/byte_stream.hpp"
#include "daemon/formats/gzip_stream.hpp"
#include "daemon/formats/threemf_package.hpp"
#include "daemon/formats/zip_archive.hpp"
#include "daemon/formats/zip_models.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

// A file of one of the core's formats.
class PlainInput : public ModelInput {
 public:
  PlainInput(ModelSource source, std::vector<std::byte> first_bytes)
      : source_(std::move(source)),
        first_bytes_(std::move(first_bytes)),
        outline_(outline_of_model({source_.bytes, first_bytes_})) {}

  [[nodiscard]] const ModelOutline& outline() const override { return outline_; }

  [[nodiscard]] Model read(std::uint64_t /*most_facets*/) override {
    return read_model({source_.bytes, first_bytes_}, [this](std::span<std::byte> into) {
      read_exactly(source_.file.get(), into, source_.path);
    });
  }

 private:
  ModelSource source_;
  std::vector<std::byte> first_bytes_;
  ModelOutline outline_;
};

// A model of one of the core's formats that gzip compressed.
class GzipInput : public ModelInput {
 public:
  explicit GzipInput(ModelSource source)
      : source_(std::move(source)),
        stream_(source_.file.get(), source_.bytes, source_.path),
        model_(stream_, "the model in the gzip archive"),
        outline_(model_.outline()) {}

  [[nodiscard]] const ModelOutline& outline() const override { return outline_; }
  [[nodiscard]] Model read(std::uint64_t /*most_facets*/) override { return model_.read(); }

 private:
  ModelSource source_;
  GzipStream stream_;
  StreamedModel model_;
  ModelOutline outline_;
};

// A model of one of the core's formats in a ZIP archive.
class ZipInput : public ModelInput {
 public:
  ZipInput(ModelSource source, std::unique_ptr<const ZipArchive> archive)
      : source_(std::move(source)),
        archive_(std::move(archive)),
        entry_(model_in(*archive_, source_.entry)),
        stream_(archive_->open(entry_)),
        model_(*stream_, in_quotes(entry_.name) + " in the archive"),
        outline_(model_.outline()) {}

  [[nodiscard]] const ModelOutline& outline() const override { return outline_; }
  [[nodiscard]] Model read(std::uint64_t /*most_facets*/) override { return model_.read(); }

 private:
  ModelSource source_;
  std::unique_ptr<const ZipArchive> archive_;
  const ZipEntry& entry_;
  std::unique_ptr<ByteStream> stream_;
  StreamedModel model_;
  ModelOutline outline_;
};

class ThreeMfInput : public ModelInput {
 public:
  ThreeMfInput(ModelSource source, std::unique_ptr<const ZipArchive> archive)
      : source_(std::move(source)), archive_(std::move(archive)), package_(*archive_) {}

  [[nodiscard]] const ModelOutline& outline() const override { return package_.outline(); }
  [[nodiscard]] Model read(std::uint64_t most_facets) override { return package_.read(most_facets); }

 private:
  ModelSource source_;
  std::unique_ptr<const ZipArchive> archive_;
  ThreeMfPackage package_;
};

}  // namespace

std::unique_ptr<ModelInput> open_model(ModelSource source) {
  std::vector<std::byte> start = read_start(source.file.get(), source.bytes, source.path);
  // The core goes first: the header of a binary STL file may hold any bytes.
  const bool plain = is_recognised({source.bytes, start});
  if (!plain && is_zip(start)) {
    auto archive = std::make_unique<const ZipArchive>(source.file.get(), source.bytes, source.path);
    if (source.entry.empty() && is_threemf(*archive))
      return std::make_unique<ThreeMfInput>(std::move(source), std::move(archive));
    return std::make_unique<ZipInput>(std::move(source), std::move(archive));
  }
  if (!source.entry.empty()) {
    throw ModelError(
        fmt::format("the ticket names the model {} in an archive, and the file is no ZIP archive: "
                    "remove \"model\" from the ticket",
                    in_quotes(source.entry)));
  }
  if (!plain && is_gzip(start)) return std::make_unique<GzipInput>(std::move(source));
  return std::make_unique<PlainInput>(std::move(source), std::move(start));
}

std::unique_ptr<ModelInput> open_model(const std::filesystem::path& path, const std::string& entry) {
  OpenFile file = open_regular(path);
  const std::uint64_t bytes = std::filesystem::file_size(path);
  return open_model(ModelSource{std::move(file), bytes, path, entry});
}

}  // namespace contourd
