#include "daemon/formats/model_input.hpp"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/formats/model_reader.hpp"
#include "daemon/formats/amf_model.hpp"
#include "daemon/formats/byte_stream.hpp"
#include "daemon/formats/gzip_stream.hpp"
#include "daemon/formats/input_limits.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/formats/threemf_package.hpp"
#include "daemon/formats/zip_archive.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/memory_room.hpp"

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

// A model of one of the core's formats in a stream, with what the stream reads from.
class StreamInput : public ModelInput {
 public:
  StreamInput(std::shared_ptr<const void> origin, std::unique_ptr<StartedStream> stream, std::string name)
      : origin_(std::move(origin)),
        stream_(std::move(stream)),
        model_(*stream_, std::move(name)),
        outline_(model_.outline()) {}

  [[nodiscard]] const ModelOutline& outline() const override { return outline_; }
  [[nodiscard]] Model read(std::uint64_t /*most_facets*/) override { return model_.read(); }

 private:
  std::shared_ptr<const void> origin_;
  std::unique_ptr<StartedStream> stream_;
  StreamedModel model_;
  ModelOutline outline_;
};

// An AMF model in a stream, with what the stream reads from.
class AmfInput : public ModelInput {
 public:
  AmfInput(std::shared_ptr<const void> origin, std::unique_ptr<StartedStream> stream, std::string name)
      : origin_(std::move(origin)),
        stream_(std::move(stream)),
        name_(std::move(name)),
        outline_(amf_outline(stream_->bytes())) {}

  [[nodiscard]] const ModelOutline& outline() const override { return outline_; }
  [[nodiscard]] Model read(std::uint64_t most_facets) override {
    return read_amf(*stream_, name_, most_facets);
  }

 private:
  std::shared_ptr<const void> origin_;
  std::unique_ptr<StartedStream> stream_;
  std::string name_;
  ModelOutline outline_;
};

// The bytes of a file.
class FileStream : public ByteStream {
 public:
  explicit FileStream(const ModelSource& source) : source_(source), left_(source.bytes) {}

  [[nodiscard]] std::uint64_t bytes() const override { return source_.bytes; }
  std::size_t read_some(std::span<std::byte> into) override {
    const std::size_t bytes = std::min<std::uint64_t>(into.size(), left_);
    read_exactly(source_.file.get(), into.first(bytes), source_.path);
    left_ -= bytes;
    return bytes;
  }

 private:
  const ModelSource& source_;
  std::uint64_t left_;
};

// A model in an archive, whose path each message about the model has.
class EntryInput : public ModelInput {
 public:
  EntryInput(std::unique_ptr<ModelInput> model, std::string name)
      : model_(std::move(model)), name_(std::move(name)) {}

  [[nodiscard]] const ModelOutline& outline() const override { return model_->outline(); }
  [[nodiscard]] Model read(std::uint64_t most_facets) override {
    try {
      return model_->read(most_facets);
    } catch (const ModelError& error) {
      const std::string_view sentence = error.what();
      if (sentence.starts_with(name_)) throw;
      throw ModelError(fmt::format("{}: {}", name_, sentence));
    }
  }

 private:
  std::unique_ptr<ModelInput> model_;
  std::string name_;
};

// A model with notes on how it was chosen, which become warnings.
class NotedInput : public ModelInput {
 public:
  NotedInput(std::unique_ptr<ModelInput> model, std::vector<std::string> notes)
      : model_(std::move(model)), notes_(std::move(notes)) {}

  [[nodiscard]] const ModelOutline& outline() const override { return model_->outline(); }
  [[nodiscard]] const SlicedArchive* sliced() const override { return model_->sliced(); }
  [[nodiscard]] Model read(std::uint64_t most_facets) override {
    Model model = model_->read(most_facets);
    model.warnings.insert(model.warnings.begin(), notes_.begin(), notes_.end());
    return model;
  }

 private:
  std::unique_ptr<ModelInput> model_;
  std::vector<std::string> notes_;
};

class ThreeMfInput : public ModelInput {
 public:
  // `held`: bytes of memory that the archive itself takes.
  explicit ThreeMfInput(std::shared_ptr<const ZipArchive> archive, std::uint64_t held = 0)
      : archive_(std::move(archive)), package_(*archive_), outline_(package_.outline()) {
    outline_.buffered_bytes += held;
  }

  [[nodiscard]] const ModelOutline& outline() const override { return outline_; }
  [[nodiscard]] Model read(std::uint64_t most_facets) override { return package_.read(most_facets); }

 private:
  std::shared_ptr<const ZipArchive> archive_;
  ThreeMfPackage package_;
  ModelOutline outline_;
};

// Finished layers.
class SlicedInput : public ModelInput {
 public:
  explicit SlicedInput(std::shared_ptr<const ZipArchive> archive)
      : archive_(std::move(archive)),
        outline_{.format = archive_.format(), .most_facets = kBoxFacets, .exact = true} {}

  [[nodiscard]] const ModelOutline& outline() const override { return outline_; }
  [[nodiscard]] const SlicedArchive* sliced() const override { return &archive_; }
  [[nodiscard]] Model read(std::uint64_t /*most_facets*/) override {
    throw ModelError(
        "the file holds finished layers for a printer's display and no model: name the printer's "
        "configuration by --printer, or give the model that the file was made from");
  }

 private:
  static constexpr std::uint64_t kBoxFacets = 12;  // facets of the box that stands for the layers

  SlicedArchive archive_;
  ModelOutline outline_;
};

// Writes the rest of the stream into a file in memory, and returns it at its beginning.
OpenFile unpacked(ByteStream& stream, const std::string& name) {
  if (stream.bytes() > kMostNestedBytes || stream.bytes() > memory_room(std::nullopt).bytes)
    throw ModelError(
        fmt::format("{} has {} bytes, and the limit for a 3MF file in an archive is {}, or the free memory: "
                    "unpack the archive, and print the 3MF file",
                    name, stream.bytes(), kMostNestedBytes));
  OpenFile file(::fdopen(::memfd_create("contourd-3mf", MFD_CLOEXEC), "w+b"));
  if (!file) throw std::system_error(errno, std::generic_category(), "cannot unpack " + name);
  std::array<std::byte, 65'536> buffer{};
  for (std::size_t bytes = 0; (bytes = stream.read_some(buffer)) > 0;)
    if (std::fwrite(buffer.data(), 1, bytes, file.get()) != bytes)
      throw std::system_error(errno, std::generic_category(), "cannot unpack " + name);
  if (std::fflush(file.get()) != 0 || std::fseek(file.get(), 0, SEEK_SET) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot unpack " + name);
  return file;
}

// Opens a 3MF file in an archive. Other archives in an archive are refused.
std::unique_ptr<ModelInput> open_nested(StartedStream& stream, const std::string& name) {
  const std::uint64_t bytes = stream.bytes();
  const OpenFile file = unpacked(stream, name);
  try {
    auto archive = std::make_shared<const ZipArchive>(file.get(), bytes, name);
    if (!is_threemf(*archive)) throw ModelError("it is an archive in an archive: unpack it");
    return std::make_unique<ThreeMfInput>(std::move(archive), bytes);
  } catch (const ModelError& error) {
    throw ModelError(fmt::format("{}: {}", name, error.what()));
  }
}

std::unique_ptr<ModelInput> open_stream(std::shared_ptr<const void> origin,
                                        std::unique_ptr<StartedStream> stream, const std::string& name) {
  const FileStart start = stream->start();
  if (!is_recognised(start) && is_zip(start.bytes)) return open_nested(*stream, name);
  if (!is_recognised(start) && is_amf(start))
    return std::make_unique<AmfInput>(std::move(origin), std::move(stream), name);
  return std::make_unique<StreamInput>(std::move(origin), std::move(stream), name);
}

std::unique_ptr<ModelInput> open_entry(const std::shared_ptr<const ZipArchive>& archive,
                                       const ZipEntry& entry) {
  const std::string name = in_quotes(entry.name) + " in the archive";
  auto stream = std::make_unique<StartedStream>(archive->open(entry), name);
  return std::make_unique<EntryInput>(open_stream(archive, std::move(stream), name), name);
}

OpenedModels open_archive(const std::shared_ptr<const ZipArchive>& archive, const ArchiveChoice& asked) {
  ZipChoice choice = choose_models(*archive, asked);
  OpenedModels opened{{}, std::move(choice.notes)};
  for (const auto& [entry, is_supported] : choice.models)
    opened.models.push_back({entry->name, is_supported, open_entry(archive, *entry)});
  return opened;
}

std::unique_ptr<ModelInput> open_gzip(ModelSource source) {
  const std::string name = "the model in the gzip archive";
  auto origin = std::make_shared<const ModelSource>(std::move(source));
  auto stream = std::make_unique<StartedStream>(
      std::make_unique<GzipStream>(origin->file.get(), origin->bytes, origin->path), name);
  return open_stream(std::move(origin), std::move(stream), name);
}

std::unique_ptr<ModelInput> open_amf(ModelSource source) {
  const std::string name = "the AMF file";
  const std::uint64_t bytes = source.bytes;
  refuse_inflation({bytes, bytes}, name);
  auto origin = std::make_shared<const ModelSource>(std::move(source));
  auto stream = std::make_unique<StartedStream>(std::make_unique<FileStream>(*origin), name);
  return std::make_unique<AmfInput>(std::move(origin), std::move(stream), name);
}

OpenedModels only(std::unique_ptr<ModelInput> input) {
  OpenedModels opened;
  opened.models.push_back({"", false, std::move(input)});
  return opened;
}

}  // namespace

OpenedModels open_models(ModelSource source) {
  std::vector<std::byte> start = read_start(source.file.get(), source.bytes, source.path);
  // The core goes first: the header of a binary STL file may hold any bytes.
  const bool plain = is_recognised({source.bytes, start});
  const std::vector<std::string>& names = source.choice.names;
  if (!plain && is_zip(start)) {
    auto archive = std::make_shared<const ZipArchive>(source.file.get(), source.bytes, source.path);
    if (names.empty() && is_threemf(*archive))
      return only(std::make_unique<ThreeMfInput>(std::move(archive)));
    if (names.empty() && is_sliced(*archive)) return only(std::make_unique<SlicedInput>(std::move(archive)));
    return open_archive(archive, source.choice);
  }
  if (!names.empty())
    throw ModelError(
        fmt::format("the ticket names the model {} in an archive, and the file is no ZIP archive: "
                    "remove \"model\" from the ticket",
                    in_quotes(names.front())));
  const std::string_view extension = model_extension(source.path.filename().string());
  if (!plain &&
      (extension == ".sl1" || extension == ".sl1s" || extension == ".sl1_svg" || extension == ".nanodlp"))
    throw ModelError(
        "its name is that of a sliced archive, and it is no ZIP file, so it is damaged or something else: "
        "slice "
        "the model again");
  if (!plain && is_amf({source.bytes, start})) return only(open_amf(std::move(source)));
  if (!plain && is_gzip(start)) return only(open_gzip(std::move(source)));
  return only(std::make_unique<PlainInput>(std::move(source), std::move(start)));
}

OpenedModels open_models(const std::filesystem::path& path, const ArchiveChoice& choice) {
  OpenFile file = open_regular(path);
  const std::uint64_t bytes = std::filesystem::file_size(path);
  return open_models(ModelSource{std::move(file), bytes, path, choice});
}

std::unique_ptr<ModelInput> open_model(const std::filesystem::path& path,
                                       const std::vector<std::string>& names) {
  OpenedModels opened = open_models(path, {names});
  if (opened.models.size() == 1)
    return std::make_unique<NotedInput>(std::move(opened.models.front().input), std::move(opened.notes));
  std::vector<std::string_view> paths;
  for (const OpenedModel& model : opened.models)
    paths.emplace_back(model.entry);
  throw ModelError(
      fmt::format("the archive holds {} models: name one of them as \"model\" in the ticket, or "
                  "unpack the archive: {}",
                  opened.models.size(), names_text(paths)));
}

}  // namespace contourd
