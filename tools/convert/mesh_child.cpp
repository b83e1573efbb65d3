#include "tools/convert/mesh_child.h"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <span>

#include "renderer/scene/files.h"
#include "tools/convert/byte_stream.h"

namespace fire3dv::convert {
namespace {

constexpr rlim_t kMostCpuSeconds = 60;
constexpr rlim_t kMostMemory = rlim_t{12} << 30;
constexpr uint32_t kComplete = 0x464d4533;  // last in the child's answer: all of it is there

void lower_limit(__rlimit_resource resource, rlim_t most) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0) return;
  limit.rlim_max = std::min(limit.rlim_max, most);
  limit.rlim_cur = std::min(limit.rlim_cur, limit.rlim_max);
  setrlimit(resource, &limit);
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
      out.put_string(m.diffuse_image);
      out.put_string(m.normal_image);
    }
    out.put(result->surfaces.size());
    for (const Surface& surface : result->surfaces) {
      out.put_array(surface.positions);
      out.put_array(surface.normals);
      out.put_array(surface.uvs);
      out.put_array(surface.indices);
      out.put(surface.material);
    }
    out.put(result->besides.size());
    for (const std::filesystem::path& path : result->besides) out.put_string(path.native());
  }
  out.put(kComplete);
  return out.take();
}

// Whatever a damaged child may have written is at most refused. False: it is not whole.
bool decode(ByteReader in, std::string& refusal, ImportedMesh& mesh) {
  size_t count = 0;
  if (!in.get_string(refusal)) return false;
  if (refusal.empty()) {
    if (!in.get(count)) return false;
    for (size_t i = 0; i < count; ++i) {
      ImportedMaterial m;
      if (!in.get_string(m.name) || !in.get(m.diffuse) || !in.get(m.emission) || !in.get(m.opacity) ||
          !in.get(m.roughness) || !in.get_string(m.diffuse_image) || !in.get_string(m.normal_image)) {
        return false;
      }
      mesh.materials.push_back(std::move(m));
    }
    if (!in.get(count)) return false;
    for (size_t i = 0; i < count; ++i) {
      Surface s;
      if (!in.get_array(s.positions) || !in.get_array(s.normals) || !in.get_array(s.uvs) ||
          !in.get_array(s.indices) || !in.get(s.material)) {
        return false;
      }
      mesh.surfaces.push_back(std::move(s));
    }
    if (!in.get(count)) return false;
    for (size_t i = 0; i < count; ++i) {
      std::string path;
      if (!in.get_string(path)) return false;
      mesh.besides.emplace_back(path);
    }
  }
  uint32_t last = 0;
  return in.get(last) && last == kComplete && in.at_end();
}

bool write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return true;
}

[[noreturn]] void be_the_child(const std::filesystem::path& file, int answer, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // it has died before it could be watched
  // The parent's handlers are not for what happens here.
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGXFSZ, SIGINT, SIGTERM})
    signal(number, SIG_DFL);
  lower_limit(RLIMIT_CORE, 0);
  lower_limit(RLIMIT_CPU, kMostCpuSeconds);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // their shadows are terabytes
  lower_limit(RLIMIT_AS, kMostMemory);
#endif
  bool ok = false;
  try {
    ok = write_all(answer, encode(import_mesh(file)));
  } catch (const std::bad_alloc&) {
    ok = write_all(answer, encode(Error{"it takes more memory than mesh files are given"}));
  } catch (const std::exception&) {  // no answer says enough
  }
  _exit(ok ? 0 : 1);
}

struct Mapping {
  void* data = MAP_FAILED;
  size_t size = 0;
  ~Mapping() {
    if (data != MAP_FAILED) munmap(data, size);
  }
};

struct FileDescriptor {
  int fd = -1;
  ~FileDescriptor() {
    if (fd >= 0) close(fd);
  }
};

}  // namespace

Result<ImportedMesh> import_mesh_in_child(const std::filesystem::path& file) {
  const std::string name = scene::quote(file.string());
  const FileDescriptor answer{memfd_create("fire3dv-mesh", MFD_CLOEXEC)};
  if (answer.fd < 0) return Error{"cannot read " + name + ": " + std::strerror(errno)};
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) return Error{"cannot read " + name + ": no process could be started for it"};
  if (child == 0) be_the_child(file, answer.fd, parent);
  int status = 0;
  pid_t ended;
  do ended = waitpid(child, &status, 0);
  while (ended < 0 && errno == EINTR);

  // How it ended may be lost where the program ignores its children; whether the answer is whole is not.
  Mapping mapping;
  const off_t size = lseek(answer.fd, 0, SEEK_END);
  std::string refusal;
  ImportedMesh mesh;
  if (size > 0) {
    mapping.size = static_cast<size_t>(size);
    mapping.data = mmap(nullptr, mapping.size, PROT_READ, MAP_PRIVATE, answer.fd, 0);
    if (mapping.data != MAP_FAILED &&
        decode(ByteReader({static_cast<const std::byte*>(mapping.data), mapping.size}), refusal, mesh)) {
      if (!refusal.empty()) return Error{"cannot read " + name + ": " + refusal};
      if (Result<void> sound = check_imported(mesh); !sound)
        return Error{"cannot read " + name + ": " + sound.error().message};
      return mesh;
    }
  }
  if (ended == child && WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    return Error{"cannot read " + name + ": it takes longer than " + std::to_string(kMostCpuSeconds) +
                 " s, or more memory than there is; is it damaged?"};
  }
  return Error{"cannot read " + name +
               ": it makes the importer fail; it is damaged, or not what it is called"};
}

}  // namespace fire3dv::convert
