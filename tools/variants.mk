# The named variants: VARIANT selects compiler, optimisation and further flags, unless the command line says
# otherwise. tools/repro.sh renders the same jobs by all of them and expects the same bits.

comma := ,
UBSAN := undefined,float-cast-overflow,float-divide-by-zero

# $(call variant,compiler,optimisation,further flags)
define variant
CXX := $(1)
OPT := $(2)
EXTRA := $(3)
endef

# g++ 12 warns about joined strings at -O3 without reason (gcc bug 105651).
NO_NOISE := -Wno-restrict

variant_release    = $(call variant,g++,-O2)
variant_gcc-O0     = $(call variant,g++,-O0)
variant_gcc-O3     = $(call variant,g++,-O3,$(NO_NOISE))
variant_gcc-lto    = $(call variant,g++,-O2,-flto=auto $(NO_NOISE))
variant_gcc-avx2   = $(call variant,g++,-O3,-mavx2 -mfma $(NO_NOISE))
variant_gcc-v4     = $(call variant,g++,-O3,-march=x86-64-v4 $(NO_NOISE))
variant_asan       = $(call variant,g++,-O1,-fsanitize=address -fsanitize=$(UBSAN) -fno-sanitize-recover=all)
variant_tsan       = $(call variant,g++,-O1,-fsanitize=thread)
variant_clang      = $(call variant,clang++,-O2)
variant_clang-O0   = $(call variant,clang++,-O0)
variant_clang-O3   = $(call variant,clang++,-O3)
variant_clang-avx2 = $(call variant,clang++,-O3,-mavx2 -mfma)
variant_clang-v4   = $(call variant,clang++,-O3,-march=x86-64-v4)
variant_clang-asan = $(call variant,clang++,-O1,-fsanitize=address -fsanitize=$(UBSAN) -fno-sanitize-recover=all)
# libstdc++ and libfmt are not instrumented: the headers of fmt are compiled in, and the readers of scenes, which
# use containers, are left out.
variant_msan       = $(call variant,clang++,-O1,-fsanitize=memory -DFMT_HEADER_ONLY \
                       -fsanitize-ignorelist=tools/msan_ignore.txt)

# The inputs' readers with libFuzzer's coverage.
variant_fuzz       = $(call variant,clang++,-O1,-fsanitize=fuzzer-no-link$(comma)address -fsanitize=$(UBSAN) \
                       -fno-sanitize-recover=all)

# Other machines: the headers of glm and fmt come from build/sysinclude, so that nothing else of this
# machine's /usr/include is seen, and the binary is static, so that qemu-user runs it without their libraries.
CROSS              := -DFMT_HEADER_ONLY -isystem build/sysinclude
variant_aarch64    = $(call variant,aarch64-linux-gnu-g++,-O2,$(CROSS))
variant_clang-aarch64 = $(call variant,clang++ --target=aarch64-linux-gnu,-O2,$(CROSS))

# The default with OpenEXR.
variant_exr        = $(call variant,g++,-O2)

$(eval $(variant_$(VARIANT)))
ifeq ($(VARIANT),exr)
EXR := yes
endif
ifneq ($(filter %aarch64,$(VARIANT)),)
LINK := -static
LIBS :=
$(shell mkdir -p build/sysinclude && ln -sfn /usr/include/glm /usr/include/fmt build/sysinclude/)
endif
