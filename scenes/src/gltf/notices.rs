//! What the importer tells the user: one sentence per kind of thing, with how many there are.

/// How many sentences there are at most that a file can have any number of.
const MAX_SAID: usize = 32;

/// Sentences in the order in which they first came up.
#[derive(Default)]
pub(super) struct Notices {
    entries: Vec<(String, usize)>,
    said: usize,
}

impl Notices {
    /// Notes something about one thing in the file, once. After many such sentences, they are only counted.
    pub(super) fn say(&mut self, sentence: impl Into<String>) {
        if self.said == MAX_SAID {
            return self.count("there is more to say of this kind", 1);
        }
        self.said += 1;
        self.entries.push((sentence.into(), 0));
    }

    /// Notes that `sentence`, about things of one kind, holds for `count` more of them.
    pub(super) fn count(&mut self, sentence: &'static str, count: usize) {
        match self.entries.iter_mut().find(|(known, _)| known == sentence) {
            Some((_, total)) => *total += count,
            None if count > 0 => self.entries.push((sentence.into(), count)),
            None => {}
        }
    }

    /// The sentences, each with its count if it has one.
    pub(super) fn into_sentences(self) -> Vec<String> {
        let with_count = |(sentence, count): (String, usize)| match count {
            0 => sentence,
            _ => format!("{sentence} ({count})"),
        };
        self.entries.into_iter().map(with_count).collect()
    }
}
