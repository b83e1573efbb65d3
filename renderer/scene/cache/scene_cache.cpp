#include "renderer/scene/cache/scene_cache.h"

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <new>
#include <system_error>

#include "base/parallel.h"
#include "renderer/scene/cache/member_bytes.h"
#include "renderer/scene/derived/derived_fields.h"
#include "scene_sources_digest.h"

namespace fire3dv::scene {

struct ArrayEntry {
  uint64_t count = 0, element_bytes = 0, checksum = 0;
};

template <typename Visit>
void visit_members(ArrayEntry& e, Visit&& visit) {
  visit(e.count, e.element_bytes, e.checksum);
}

template <typename Visit>
void visit_members(SourceFile& s, Visit&& visit) {
  visit(s.uri, s.digest);
}

namespace {

// File layout: head; three member sections (sources, table, scene); arrays, each aligned to kAlignment.
constexpr char kMagic[8] = {'F', '3', 'D', 'V', 'S', 'C', 'N', '\0'};
constexpr uint64_t kAlignment = 64;
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 36;
constexpr uint64_t kMaxMemberBytes = uint64_t{1} << 30;
constexpr size_t kChunk = size_t{1} << 18;  // fits a core's cache between checksum and copy

struct Head {
  char magic[sizeof(kMagic)];
  Digest kind;
  uint64_t file_bytes;
  uint64_t sources_bytes, table_bytes, scene_bytes;
  uint64_t sources_checksum, table_checksum, scene_checksum;
  uint64_t head_checksum;  // of all preceding bytes
};
static_assert(std::is_trivially_copyable_v<Head> && sizeof(Head) == 104);

uint64_t aligned(uint64_t offset) {
  return (offset + kAlignment - 1) / kAlignment * kAlignment;
}

uint64_t checksum_of(std::span<const std::byte> bytes) {
  Checksum checksum;
  checksum.add(bytes);
  return checksum.value();
}

std::span<const std::byte> head_bytes(const Head& head) {
  return std::as_bytes(std::span(&head, 1)).first(offsetof(Head, head_checksum));
}

template <typename Visit>
void visit_all_arrays(LoadedScene& loaded, Visit&& visit) {
  visit_arrays(loaded.scene, visit);
  visit_arrays(loaded.derived, visit);
}

// An array of the file, read in parallel later.
struct WantedArray {
  ArrayEntry entry;
  uint64_t offset = 0;
  std::function<bool()> read;
};

template <typename T>
bool read_array(const OpenFile& file, const ArrayEntry& entry, uint64_t offset, std::vector<T>& array) {
  static_assert(std::is_trivially_copyable_v<T>);
  array.reserve(entry.count);
#ifdef MADV_HUGEPAGE
  // Huge pages reduce page faults of large arrays; failure is harmless.
  if (entry.count * sizeof(T) >= (size_t{2} << 20)) {
    constexpr uintptr_t kPage = 4096;
    const auto first = (reinterpret_cast<uintptr_t>(array.data()) + kPage - 1) / kPage * kPage;
    madvise(reinterpret_cast<void*>(first), entry.count * sizeof(T) - kPage, MADV_HUGEPAGE);
  }
#endif
  // Copied through a small buffer: a mapped file would crash the program if someone truncates it.
  constexpr size_t kStep = kChunk / sizeof(T) / Checksum::kBlock * Checksum::kBlock;
  std::vector<T> chunk(std::min<size_t>(kStep, entry.count));
  Checksum checksum;
  for (uint64_t done = 0; done < entry.count;) {
    const auto count = static_cast<size_t>(std::min<uint64_t>(chunk.size(), entry.count - done));
    const std::span<T> part(chunk.data(), count);
    if (!file.read(offset + done * sizeof(T), std::as_writable_bytes(part))) return false;
    checksum.add(std::as_bytes(part));
    array.insert(array.end(), part.begin(), part.end());
    done += count;
  }
  return checksum.value() == entry.checksum;
}

struct OpenedSceneFile {
  OpenFile file;
  Head head;
};

Result<OpenedSceneFile> open_scene_file(const std::filesystem::path& path) {
  Result<OpenFile> file = OpenFile::open(path, kMaxFileBytes);
  if (!file) return file.error();
  Head head{};
  if (!file->read(0, std::as_writable_bytes(std::span(&head, 1)))) return Error{"it is too short"};
  if (std::memcmp(head.magic, kMagic, sizeof(kMagic)) != 0) return Error{"it is not a cached scene"};
  if (head.kind != scene_file_format_id()) return Error{"another version of this program has written it"};
  if (head.head_checksum != checksum_of(head_bytes(head))) return Error{"it is damaged"};
  const uint64_t most = std::min(kMaxMemberBytes, file->size());
  if (head.file_bytes != file->size() || head.sources_bytes > most || head.table_bytes > most ||
      head.scene_bytes > most)
    return Error{"its length differs from its header"};
  return OpenedSceneFile{std::move(*file), head};
}

template <typename... T>
Result<void> read_members(const OpenFile& file, uint64_t offset, uint64_t size, uint64_t checksum,
                          T&... members) {
  std::vector<std::byte> bytes(size);
  if (!file.read(offset, bytes)) return Error{"it is too short"};
  if (checksum_of(bytes) != checksum) return Error{"it is damaged"};
  MemberReader reader(bytes);
  reader(members...);
  if (!reader.was_right()) return Error{"its contents differ from its header"};
  return {};
}

Result<void> read_arrays(const OpenedSceneFile& opened, const std::vector<ArrayEntry>& table,
                         LoadedScene& loaded) {
  std::vector<WantedArray> wanted;
  uint64_t offset =
      sizeof(Head) + opened.head.sources_bytes + opened.head.table_bytes + opened.head.scene_bytes;
  bool fits = true;
  visit_all_arrays(loaded, [&]<typename T>(std::vector<T>& array) {
    if (!fits || wanted.size() >= table.size()) {
      fits = false;
      return;
    }
    const ArrayEntry& entry = table[wanted.size()];
    offset = aligned(offset);
    fits = entry.element_bytes == sizeof(T) && offset <= opened.file.size() &&
           entry.count <= (opened.file.size() - offset) / sizeof(T);
    wanted.push_back({entry, offset, [&opened, &array, entry, offset] {
                        return read_array(opened.file, entry, offset, array);
                      }});
    offset += entry.count * sizeof(T);
  });
  if (!fits || wanted.size() != table.size() || offset != opened.file.size())
    return Error{"its arrays differ from its header"};
  // Largest first, for balanced load.
  std::stable_sort(wanted.begin(), wanted.end(), [](const WantedArray& a, const WantedArray& b) {
    return a.entry.count * a.entry.element_bytes > b.entry.count * b.entry.element_bytes;
  });
  std::atomic<bool> right{true};
  parallel_for(wanted.size(), [&](size_t i) {
    if (!wanted[i].read()) right = false;
  });
  if (!right) return Error{"it is damaged"};
  return {};
}

Result<CachedScene> read_whole(const std::filesystem::path& path) {
  Result<OpenedSceneFile> opened = open_scene_file(path);
  if (!opened) return opened.error();
  const Head& head = opened->head;
  CachedScene cached;
  std::vector<ArrayEntry> table;
  LoadedScene& loaded = cached.loaded;
  uint64_t offset = sizeof(Head);
  if (auto done =
          read_members(opened->file, offset, head.sources_bytes, head.sources_checksum, cached.sources);
      !done)
    return done.error();
  offset += head.sources_bytes;
  if (auto done = read_members(opened->file, offset, head.table_bytes, head.table_checksum, table); !done)
    return done.error();
  offset += head.table_bytes;
  if (auto done = read_members(opened->file, offset, head.scene_bytes, head.scene_checksum, loaded.scene,
                               loaded.derived);
      !done)
    return done.error();
  if (auto done = read_arrays(*opened, table, loaded); !done) return done.error();
  if (auto right = check_scene(loaded.scene); !right) return right.error();
  if (auto right = check_derived(loaded.scene, loaded.derived); !right) return right.error();
  return cached;
}

}  // namespace

Digest scene_file_format_id() {
  // Digest of scene code, structure sizes and byte order.
  std::string text = FIRE3DV_SCENE_SOURCES;
  const uint32_t order = 0x01020304;
  text.append(reinterpret_cast<const char*>(&order), sizeof(order));
  text += std::to_string(sizeof(Scene)) + "/" + std::to_string(sizeof(Derived));
  return digest_of(std::as_bytes(std::span(text)));
}

uint64_t array_bytes(const LoadedScene& loaded) {
  uint64_t bytes = 0;
  visit_all_arrays(const_cast<LoadedScene&>(loaded),
                   [&]<typename T>(std::vector<T>& array) { bytes += array.size() * sizeof(T); });
  return bytes;
}

Result<void> write_scene_file(const std::filesystem::path& path, const LoadedScene& loaded,
                              const std::vector<SourceFile>& sources) {
  // Visitors take mutable references; this one does not modify the scene.
  auto& scene = const_cast<LoadedScene&>(loaded);
  std::vector<ArrayEntry> table;
  std::vector<std::span<const std::byte>> arrays;
  visit_all_arrays(scene, [&]<typename T>(std::vector<T>& array) {
    arrays.push_back(std::as_bytes(std::span(array)));
    table.push_back({array.size(), sizeof(T), 0});
  });
  parallel_for(arrays.size(), [&](size_t i) { table[i].checksum = checksum_of(arrays[i]); });

  MemberWriter sources_members, table_members, scene_members;
  sources_members(const_cast<std::vector<SourceFile>&>(sources));
  table_members(table);
  scene_members(scene.scene, scene.derived);
  Head head{};
  std::memcpy(head.magic, kMagic, sizeof(kMagic));
  head.kind = scene_file_format_id();
  head.sources_bytes = sources_members.bytes().size();
  head.table_bytes = table_members.bytes().size();
  head.scene_bytes = scene_members.bytes().size();
  head.sources_checksum = checksum_of(sources_members.bytes());
  head.table_checksum = checksum_of(table_members.bytes());
  head.scene_checksum = checksum_of(scene_members.bytes());

  static constexpr std::byte kGap[kAlignment]{};
  std::vector<std::span<const std::byte>> pieces{std::as_bytes(std::span(&head, 1)), sources_members.bytes(),
                                                 table_members.bytes(), scene_members.bytes()};
  uint64_t offset = sizeof(Head) + head.sources_bytes + head.table_bytes + head.scene_bytes;
  for (const std::span<const std::byte>& array : arrays) {
    pieces.push_back(std::span(kGap).first(aligned(offset) - offset));
    pieces.push_back(array);
    offset = aligned(offset) + array.size();
  }
  head.file_bytes = offset;
  head.head_checksum = checksum_of(head_bytes(head));
  return write_cache_file(path, pieces);
}

Result<std::vector<SourceFile>> read_scene_sources(const std::filesystem::path& path) {
  Result<OpenedSceneFile> opened = open_scene_file(path);
  if (!opened) return opened.error();
  std::vector<SourceFile> sources;
  const Head& head = opened->head;
  if (auto done =
          read_members(opened->file, sizeof(Head), head.sources_bytes, head.sources_checksum, sources);
      !done)
    return done.error();
  return sources;
}

Result<CachedScene> read_scene_file(const std::filesystem::path& path) {
  try {
    return read_whole(path);
  } catch (const std::bad_alloc&) {
    return Error{"it does not fit into memory"};
  }
}

namespace {

using Place = SceneCacheSettings::Place;
constexpr std::string_view kEnding = ".scene", kEndingBeside = ".fire3dv-cache";

// True if all files but the asset's own are unchanged. Those that could not be read have the digest 0.
bool others_are_the_same(const std::filesystem::path& asset, const std::vector<SourceFile>& sources,
                         uint64_t max_file_bytes, DigestCache& known) {
  const AssetFolder folder(asset);
  for (size_t i = 1; i < sources.size(); ++i) {
    Digest digest{};
    if (const auto path = folder.resolve(sources[i].uri)) {
      if (const auto held = known.of(*path, max_file_bytes)) digest = held->digest;
    }
    if (digest != sources[i].digest) return false;
  }
  return true;
}

bool same(const std::vector<SourceFile>& a, const std::vector<SourceFile>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const SourceFile& x, const SourceFile& y) {
    return x.uri == y.uri && x.digest == y.digest;
  });
}

}  // namespace

std::filesystem::path SceneCache::place_of(const std::filesystem::path& asset, const Digest& own) const {
  if (settings_.place == Place::beside_the_asset) return asset.string() + std::string(kEndingBeside);
  // The name has half of the digest; the entry contains the whole one.
  return settings_.folder / (hex(std::span(own).first(16)) + std::string(kEnding));
}

std::optional<LoadedScene> SceneCache::find(const std::filesystem::path& asset, uint64_t max_file_bytes) {
  if (settings_.place == Place::nowhere) return std::nullopt;
  if (settings_.place == Place::folder) digests_ = DigestCache(settings_.folder, asset);
  const auto stamped = digests_.of(asset, max_file_bytes);
  if (!stamped) return std::nullopt;  // the loader reports the error
  known_ = *stamped;
  const Digest& own = known_->digest;
  const std::filesystem::path path = place_of(asset, own);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  const auto unusable = [&](const std::string& why) {
    notes_.push_back("warning: cache: " + quote(path.string()) + " is rebuilt: " + why);
    return std::nullopt;
  };
  const auto sources = read_scene_sources(path);
  if (!sources) return unusable(sources.error().message);
  const bool own_is_the_same =
      !sources->empty() && sources->front().uri.empty() && sources->front().digest == own;
  if (!own_is_the_same || !others_are_the_same(asset, *sources, max_file_bytes, digests_))
    return unusable("files of the scene have changed");
  auto cached = read_scene_file(path);
  if (!cached) return unusable(cached.error().message);
  if (!same(cached->sources, *sources)) return unusable("it changed while it was read");
  touch(path);
  digests_.store();
  cached->loaded.scene.source = asset;
  sources_ = std::move(cached->sources);
  return std::move(cached->loaded);
}

Result<void> SceneCache::store(const std::filesystem::path& asset, const LoadedScene& loaded,
                               const std::vector<SourceFile>& sources) {
  if (settings_.place == Place::nowhere || sources.empty()) return {};
  const uint64_t bytes = array_bytes(loaded);
  if (bytes < settings_.least_scene_bytes) return {};
  if (settings_.place == Place::beside_the_asset) {
    return write_scene_file(place_of(asset, sources.front().digest), loaded, sources);
  }
  if (bytes > settings_.max_bytes) return {};
  std::error_code error;
  std::filesystem::create_directories(settings_.folder, error);
  if (error)
    return Error{"cannot make the folder " + quote(settings_.folder.string()) + ": " + error.message()};
  auto written = write_scene_file(place_of(asset, sources.front().digest), loaded, sources);
  remove_oldest(settings_.folder, kEnding, settings_.max_bytes);
  if (written) digests_.store();
  return written;
}

}  // namespace fire3dv::scene
