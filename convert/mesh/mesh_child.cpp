#include "convert/mesh/mesh_import.h"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "base/text.h"

namespace fire3dv::convert {

// Binary serialisation between processes of one program, in native byte order. Reads are bounds-checked: each
// get returns whether the data was complete.
class ByteWriter {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(&value, sizeof value);
  }
  template <typename T>
  void put_array(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(values.size());
    append(values.data(), values.size() * sizeof(T));
  }
  void put_string(const std::string& text) {
    put(text.size());
    append(text.data(), text.size());
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void append(const void* data, size_t size) {
    const auto* from = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), from, from + size);
  }
  std::vector<std::byte> bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <typename T>
  [[nodiscard]] bool get(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return copy(&value, sizeof value);
  }
  template <typename T>
  [[nodiscard]] bool get_array(std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    size_t count = 0;
    if (!get(count) || count > rest_.size() / sizeof(T)) return false;
    values.resize(count);
    return copy(values.data(), count * sizeof(T));
  }
  [[nodiscard]] bool get_string(std::string& text) {
    size_t size = 0;
    if (!get(size) || size > rest_.size()) return false;
    text.resize(size);
    return copy(text.data(), size);
  }
  bool at_end() const { return rest_.empty(); }

 private:
  bool copy(void* to, size_t size) {
    if (rest_.size() < size) return false;
    if (size > 0) std::memcpy(to, rest_.data(), size);
    rest_ = rest_.subspan(size);
    return true;
  }
  std::span<const std::byte> rest_;
};

namespace {

constexpr rlim_t kMaxCpuSeconds = 60;
constexpr rlim_t kMaxMemory = rlim_t{4} << 30;
constexpr uint32_t kComplete = 0x464d4534;  // end marker of a complete answer

void lower_limit(__rlimit_resource resource, rlim_t most) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0) return;
  limit.rlim_max = std::min(limit.rlim_max, most);
  limit.rlim_cur = std::min(limit.rlim_cur, limit.rlim_max);
  setrlimit(resource, &limit);
}

// Memory inherited from the parent counts against the child's limit.
[[maybe_unused]] rlim_t address_space_bytes() {
  std::ifstream pages("/proc/self/statm");
  rlim_t count = 0;
  pages >> count;
  return count * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

// RLIMIT_CPU counts for the process; the limit is raised for each file.
void limit_next_cpu_seconds() {
  rusage used{};
  rlimit limit{};
  if (getrusage(RUSAGE_SELF, &used) != 0 || getrlimit(RLIMIT_CPU, &limit) != 0) return;
  limit.rlim_cur = std::min(
      limit.rlim_max, static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + kMaxCpuSeconds);
  setrlimit(RLIMIT_CPU, &limit);
}

void put_placement(const ImagePlacement& placement, ByteWriter& out) {
  out.put(placement.scale);
  out.put(placement.offset);
  out.put(static_cast<uint8_t>(placement.wrap_u));
  out.put(static_cast<uint8_t>(placement.wrap_v));
}

bool get_placement(ByteReader& in, ImagePlacement& placement) {
  uint8_t wrap_u = 0, wrap_v = 0;
  if (!in.get(placement.scale) || !in.get(placement.offset) || !in.get(wrap_u) || !in.get(wrap_v))
    return false;
  constexpr auto kMaxWrap = static_cast<uint8_t>(Wrap::clamp);
  if (wrap_u > kMaxWrap || wrap_v > kMaxWrap) return false;
  placement.wrap_u = static_cast<Wrap>(wrap_u);
  placement.wrap_v = static_cast<Wrap>(wrap_v);
  return true;
}

std::vector<std::byte> encode(const Result<ImportedMesh>& result) {
  ByteWriter out;
  out.put_string(result ? "" : result.error().message);
  if (result) {
    out.put(result->materials.size());
    for (const ImportedMaterial& m : result->materials) {
      out.put_string(m.name);
      out.put(m.diffuse);
      out.put(m.emission);
      out.put(m.opacity);
      out.put(m.roughness);
      out.put(m.metallic);
      for (const bool flag : {m.is_default, m.is_blended, m.is_exact}) out.put<uint8_t>(flag);
      out.put(m.alpha_cutoff);
      out.put_string(m.diffuse_image);
      out.put_string(m.normal_image);
      for (const std::string* name :
           {&m.emission_image, &m.roughness_image, &m.metallic_image, &m.opacity_image})
        out.put_string(*name);
      out.put(static_cast<uint8_t>(m.opacity_channel));
      for (const ImagePlacement* placement :
           {&m.diffuse_placement, &m.normal_placement, &m.emission_placement, &m.roughness_placement,
            &m.opacity_placement})
        put_placement(*placement, out);
    }
    out.put(result->surfaces.size());
    for (const Surface& surface : result->surfaces) {
      out.put_array(surface.positions);
      out.put_array(surface.normals);
      out.put_array(surface.uvs);
      out.put_array(surface.colors);
      out.put_array(surface.indices);
      out.put(surface.material);
    }
    out.put(result->images.size());
    for (const EmbeddedImage& image : result->images) {
      out.put_string(image.name);
      out.put_array(image.bytes);
    }
    out.put(result->besides.all().size());
    for (const Sources::Source& source : result->besides.all()) {
      out.put_string(source.file.native());
      out.put<uint8_t>(source.stamp.exists);
      for (const uint64_t value : {source.stamp.size, source.stamp.inode}) out.put(value);
      for (const int64_t value : {source.stamp.modified_ns, source.stamp.changed_ns}) out.put(value);
    }
    out.put(result->nodes.size());
    for (const ImportedNode& node : result->nodes) {
      out.put_string(node.name);
      out.put(node.parent);
      out.put(node.file_from_node);
      out.put_string(node.mesh_name);
    }
    out.put_array(result->surface_nodes);
    for (const auto* texts : {&result->losses, &result->warnings}) {
      out.put(texts->size());
      for (const std::string& text : *texts) out.put_string(text);
    }
  }
  out.put(kComplete);
  return out.take();
}

// Decodes the answer of a possibly compromised child with bounds checks. Returns false when it is incomplete.
bool decode(ByteReader in, std::string& refusal, ImportedMesh& mesh) {
  size_t count = 0;
  if (!in.get_string(refusal)) return false;
  if (refusal.empty()) {
    if (!in.get(count)) return false;
    for (size_t i = 0; i < count; ++i) {
      ImportedMaterial m;
      uint8_t is_default = 0, is_blended = 0, is_exact = 0, opacity_channel = 0;
      if (!in.get_string(m.name) || !in.get(m.diffuse) || !in.get(m.emission) || !in.get(m.opacity) ||
          !in.get(m.roughness) || !in.get(m.metallic) || !in.get(is_default) || !in.get(is_blended) ||
          !in.get(is_exact) || !in.get(m.alpha_cutoff) || !in.get_string(m.diffuse_image) ||
          !in.get_string(m.normal_image) || !in.get_string(m.emission_image) ||
          !in.get_string(m.roughness_image) || !in.get_string(m.metallic_image) ||
          !in.get_string(m.opacity_image) || !in.get(opacity_channel) ||
          opacity_channel > static_cast<uint8_t>(OpacityChannel::blue) ||
          !get_placement(in, m.diffuse_placement) || !get_placement(in, m.normal_placement) ||
          !get_placement(in, m.emission_placement) || !get_placement(in, m.roughness_placement) ||
          !get_placement(in, m.opacity_placement)) {
        return false;
      }
      m.opacity_channel = static_cast<OpacityChannel>(opacity_channel);
      m.is_default = is_default != 0;
      m.is_blended = is_blended != 0;
      m.is_exact = is_exact != 0;
      mesh.materials.push_back(std::move(m));
    }
    if (!in.get(count)) return false;
    for (size_t i = 0; i < count; ++i) {
      Surface s;
      if (!in.get_array(s.positions) || !in.get_array(s.normals) || !in.get_array(s.uvs) ||
          !in.get_array(s.colors) || !in.get_array(s.indices) || !in.get(s.material)) {
        return false;
      }
      mesh.surfaces.push_back(std::move(s));
    }
    if (!in.get(count)) return false;
    for (size_t i = 0; i < count; ++i) {
      EmbeddedImage image;
      if (!in.get_string(image.name) || !in.get_array(image.bytes)) return false;
      mesh.images.push_back(std::move(image));
    }
    if (!in.get(count)) return false;
    for (size_t i = 0; i < count; ++i) {
      std::string path;
      scene::FileStamp stamp;
      uint8_t exists = 0;
      if (!in.get_string(path) || !in.get(exists) || !in.get(stamp.size) || !in.get(stamp.inode) ||
          !in.get(stamp.modified_ns) || !in.get(stamp.changed_ns)) {
        return false;
      }
      stamp.exists = exists != 0;
      mesh.besides.add({path, stamp});
    }
    if (!in.get(count)) return false;
    for (size_t i = 0; i < count; ++i) {
      ImportedNode node;
      if (!in.get_string(node.name) || !in.get(node.parent) || !in.get(node.file_from_node) ||
          !in.get_string(node.mesh_name))
        return false;
      mesh.nodes.push_back(std::move(node));
    }
    if (!in.get_array(mesh.surface_nodes)) return false;
    for (auto* texts : {&mesh.losses, &mesh.warnings}) {
      if (!in.get(count)) return false;
      for (size_t i = 0; i < count; ++i) {
        std::string text;
        if (!in.get_string(text)) return false;
        texts->push_back(std::move(text));
      }
    }
  }
  uint32_t last = 0;
  return in.get(last) && last == kComplete && in.at_end();
}

// Sends all bytes. Returns false when the peer is gone.
bool send_all(int to, const void* data, size_t size) {
  const auto* from = static_cast<const std::byte*>(data);
  while (size > 0) {
    const ssize_t sent = send(to, from, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    from += sent;
    size -= static_cast<size_t>(sent);
  }
  return true;
}

bool receive_all(int from, void* data, size_t size) {
  auto* to = static_cast<std::byte*>(data);
  while (size > 0) {
    const ssize_t got = recv(from, to, size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    size -= static_cast<size_t>(got);
  }
  return true;
}

bool write_at_start(int fd, std::span<const std::byte> bytes) {
  for (size_t at = 0; at < bytes.size();) {
    const ssize_t written = pwrite(fd, bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += static_cast<size_t>(written);
  }
  return true;
}

std::vector<std::byte> answer_to(const std::string& file, ImportRequest request) {
  try {
    return encode(import_mesh(file, request));
  } catch (const std::bad_alloc&) {
    return encode(Error{"it takes more memory than the limit of mesh files"});
  } catch (const std::exception&) {
    return encode(Error{"the importer gives up on it"});
  }
}

[[noreturn]] void run_child(int requests, int answer, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // the parent died before PR_SET_PDEATHSIG took effect
  // Resets the parent's signal handlers and ignores Ctrl-C.
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGXFSZ, SIGTERM})
    signal(number, SIG_DFL);
  signal(SIGINT, SIG_IGN);
  lower_limit(RLIMIT_CORE, 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // sanitizers reserve terabytes of
                                                                     // address space
  lower_limit(RLIMIT_AS, address_space_bytes() + kMaxMemory);
#endif
  size_t size = 0;
  while (receive_all(requests, &size, sizeof size)) {
    std::string file(size, '\0');
    ImportRequest request;
    if (!receive_all(requests, file.data(), size) || !receive_all(requests, &request, sizeof request)) break;
    limit_next_cpu_seconds();
    const std::vector<std::byte> bytes = answer_to(file, request);
    size = ftruncate(answer, 0) == 0 && write_at_start(answer, bytes) ? bytes.size() : 0;
    if (!send_all(requests, &size, sizeof size)) break;
  }
  _exit(0);
}

// Reads up to `size` bytes.
std::vector<std::byte> read_from_start(int fd, size_t size) {
  std::vector<std::byte> bytes(size);
  size_t at = 0;
  while (at < size) {
    const ssize_t got = pread(fd, bytes.data() + at, size - at, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    at += static_cast<size_t>(got);
  }
  bytes.resize(at);
  return bytes;
}

}  // namespace

bool MeshImportProcess::start() {
  if (child_ > 0) return true;
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return false;
  requests_ = ends[0];
  answer_ = memfd_create("fire3dv-mesh", MFD_CLOEXEC);
  const pid_t parent = getpid();
  child_ = answer_ < 0 ? -1 : fork();
  if (child_ == 0) {
    close(ends[0]);
    run_child(ends[1], answer_, parent);
  }
  close(ends[1]);
  if (child_ < 0) end();
  return child_ > 0;
}

int MeshImportProcess::end() {
  // shutdown() reaches the child even if other children hold copies of the descriptor.
  if (requests_ >= 0) {
    shutdown(requests_, SHUT_RDWR);
    close(requests_);
  }
  if (answer_ >= 0) close(answer_);
  requests_ = answer_ = -1;
  if (child_ <= 0) return 0;
  int status = 0;
  pid_t ended;
  do ended = waitpid(child_, &status, 0);
  while (ended < 0 && errno == EINTR);
  child_ = -1;
  return ended < 0 ? 0 : status;  // the status is lost where the program ignores SIGCHLD
}

size_t MeshImportProcess::ask(const std::filesystem::path& file, ImportRequest request) {
  const std::string& path = file.native();
  size_t size = path.size();
  if (!send_all(requests_, &size, sizeof size) || !send_all(requests_, path.data(), path.size()) ||
      !send_all(requests_, &request, sizeof request) || !receive_all(requests_, &size, sizeof size)) {
    return 0;
  }
  // The reported size is untrusted; it must match the bytes written.
  const off_t written = lseek(answer_, 0, SEEK_END);
  return written > 0 && static_cast<size_t>(written) == size ? size : 0;
}

Result<ImportedMesh> MeshImportProcess::import(const std::filesystem::path& file, ImportRequest request) {
  const std::string name = quote(file.string());
  if (!start()) return Error{"cannot read " + name + ": no process could be started for it"};
  const std::vector<std::byte> answer = read_from_start(answer_, ask(file, request));
  std::string refusal;
  ImportedMesh mesh;
  if (decode(ByteReader(answer), refusal, mesh)) {
    if (!refusal.empty()) return Error{"cannot read " + name + ": " + refusal};
    if (Result<void> sound = check_imported(mesh); !sound)
      return Error{"cannot read " + name + ": " + sound.error().message};
    return mesh;
  }
  const int status = end();
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    return Error{"cannot read " + name + ": it takes longer than " + std::to_string(kMaxCpuSeconds) +
                 " s, or more memory than there is; is it damaged?"};
  }
  return Error{"cannot read " + name +
               ": the importer failed; the file is damaged, or of another format than its name"};
}

}  // namespace fire3dv::convert
