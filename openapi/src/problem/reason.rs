//! The reasons that this version gives; clients must expect others.

macro_rules! reasons {
    ($($(#[doc = $words:literal])+ $name:ident)*) => {
        $($(#[doc = $words])+ pub const $name: &str = stringify!($name);)*

        /// Every reason, and what it says.
        pub const ALL: &[(&str, &[&str])] = &[$(($name, &[$($words),+])),*];
    };
}

reasons! {
    /// A number is NaN or infinite.
    NOT_FINITE
    /// A number lies outside its range.
    OUT_OF_RANGE
    /// A list or text is too long or too short.
    WRONG_LENGTH
    /// A field contradicts another.
    INCONSISTENT
    /// A field that no one knows.
    UNKNOWN_FIELD
    /// Not JSON, a missing field, or a value of another type.
    MALFORMED
    /// An id that is none.
    INVALID_ID
    /// Nothing goes by this name.
    NO_SUCH_RESOURCE
    /// An epoch that another one has taken over from.
    EPOCH_SUPERSEDED
    /// The resource is not what `If-Match` says.
    ETAG_MISMATCH
    /// There is something already where `If-None-Match: *` wants nothing.
    ALREADY_THERE
    /// The body is compressed or encoded in another way.
    UNSUPPORTED_ENCODING
    /// A character that moves the cursor, hides text or turns its direction.
    HIDDEN_CHARACTER
    /// The body is larger than allowed.
    BODY_TOO_LARGE
    /// The robot is stopping with the server.
    DRAINING
    /// The robot's clock ran backwards within an epoch.
    CLOCK_WENT_BACK
    /// More is waiting than can be done in time: requests of a robot, evolutions or comparisons of the server.
    QUEUE_FULL
    /// A limit of the server is reached.
    LIMIT_REACHED
    /// The path exists, the method does not.
    METHOD_NOT_ALLOWED
    /// The body is in another format.
    UNSUPPORTED_MEDIA_TYPE
    /// The body did not arrive in time.
    BODY_TIMEOUT
    /// The store did not keep it.
    STORE_FAILED
    /// It is kept and cannot be read: a newer version of the server wrote it.
    UNREADABLE
    /// The part of the server that drove the robot failed.
    TASK_DIED
    /// The computation of the robot does not end.
    ROBOT_FAILED
    /// A stop came after this resume.
    OVERTAKEN
    /// A robot that could not be told.
    NOT_TOLD
    /// Robots use this prior: `value` is the id of one of them.
    PRIOR_IN_USE
    /// It comes with the server and can be neither replaced nor removed.
    BUILT_IN
    /// No prior goes by this name.
    UNKNOWN_PRIOR
    /// No simulated environment goes by this name.
    UNKNOWN_ENVIRONMENT
    /// No method, or none with so many slots, goes by this name.
    UNKNOWN_METHOD
    /// No preset of a floor or a link goes by this name.
    UNKNOWN_PRESET
    /// Something stands twice in a list.
    REPEATED
    /// This key came with another body before.
    IDEMPOTENCY_KEY_REUSED
    /// Something goes by this name already, or will.
    NAME_TAKEN
    /// It is still waiting or going on; cancel it first.
    NOT_ENDED
    /// It has ended already.
    ENDED
    /// There is nothing to show yet.
    NOTHING_YET
    /// A web page of another origin asks.
    FOREIGN_ORIGIN
    /// The request names a host that this server is not known by.
    FOREIGN_HOST
    /// A form of any web page could have sent it.
    FORM_REQUEST
    /// The request carries no token.
    TOKEN_MISSING
    /// The token is not that of this server.
    TOKEN_WRONG
}
